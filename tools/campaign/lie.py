"""Lies: what a robot's devices or its map tell it is wrong; whether it touches anything, and what
it says.

Unlike a fault, a lie begins with the run and no driver can see it. The agents believe their usual
configuration; what is so stands in a file of the simulated world. Runs under the bench's clock.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from maps.map_folder import load_map_folder
from maps.pose import Pose
from robot_agent.config import find_map
from tools.bench.fleet import Fleet, FleetLog, run_bench
from tools.simulation.truth.truth import load_truth

_MAP = "paper_lab"
_DEVICE_PARTS = ("laser.mount", "laser.ignore", "laser.health", "base.wheel_scale")
_DURATION_S = 180.0


@dataclass(frozen=True, slots=True)
class Lie:
    """A lie: what is so, by a shipped truth, and who is there.

    starts: of the robots, map_from_base; None: drawn by the seed.
    """

    name: str
    what: str
    truth: str = "rough"
    strangers: int = 0
    starts: tuple[Pose, ...] | None = None
    robots: int = 3


@dataclass(frozen=True, slots=True)
class Told:
    """What came of a lie in runs of several seeds.

    contacts: of all robots. robots, stood: in all runs, and those that stood for a reason; said:
    the first robot's words at that, empty if none; after_s: s until each stood. warned: by part of
    the agent, s until each robot that warned of it did. off: largest error of a pose that was
    called localized, m.
    """

    lie: Lie
    contacts: int
    robots: int
    after_s: tuple[float, ...]
    said: str
    warned: Mapping[str, tuple[float, ...]]
    off: float

    @property
    def complaints(self) -> list[str]:
        """What must not be: a contact."""
        return [f"{self.contacts} contacts"] if self.contacts else []


def tell(lie: Lie, seeds: Sequence[int], progress: Callable[[float], None]) -> Told:
    """Run a lie with every seed; progress: called with the seconds done.

    Raises MapError where the map is missing, ValueError where a start has no room.
    """
    runs = [_run(lie, seed, number, progress) for number, seed in enumerate(seeds)]
    each = [robot for figures, _ in runs for robot in figures["each"]]
    stood = [robot for robot in each if robot["stood_s"] is not None]
    return Told(
        lie,
        contacts=sum(figures["contacts"] for figures, _ in runs),
        robots=len(each),
        after_s=tuple(robot["stood_s"] for robot in stood),
        said=stood[0]["said"] if stood else "",
        warned={
            part: tuple(robot["warned_s"][part] for robot in each if part in robot["warned_s"])
            for part in _DEVICE_PARTS
        },
        off=max(off for _, off in runs),
    )


def _run(
    lie: Lie, seed: int, number: int, progress: Callable[[float], None]
) -> tuple[dict[str, Any], float]:
    """Return the bench's figures of one run and the largest error of a localized pose, m."""
    folder = load_map_folder(find_map(_MAP, Path.cwd()), "border")
    starts = None if lie.starts is None else list(lie.starts)
    robots = lie.robots if starts is None else len(starts)
    truth = load_truth(lie.truth)
    fleet = Fleet(folder, robots, seed, starts=starts, strangers=lie.strangers, truth=truth)
    errors = [0.0]

    def sample(t: float) -> None:
        errors.extend(_errors(fleet))
        progress(number * _DURATION_S + t)

    return run_bench(fleet, _DURATION_S, sample, FleetLog(fleet)), max(errors)


def _errors(fleet: Fleet) -> list[float]:
    """Return how far off each pose is that is called localized, m."""
    poses = [(robot.agent.pose_tracker.localized_pose_at(fleet.t), robot) for robot in fleet.robots]
    return [
        math.dist(pose[:2], robot.rig.body.pose[:2]) for pose, robot in poses if pose is not None
    ]


def lies_table(told: Sequence[Told]) -> str:
    """Return all outcomes as a Markdown table."""
    lines = [
        "| lie | what is so | contacts | robots that stood, after | warned of | pose off by "
        "| first words | |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for each in told:
        stood = _robots(each.after_s, each.robots)
        warned = "; ".join(
            f"{part}: {_robots(after_s, each.robots)}"
            for part, after_s in each.warned.items()
            if after_s
        )
        verdict = "; ".join(each.complaints) or "ok"
        lines.append(
            f"| {each.lie.name} | {each.lie.what} | {each.contacts} | {stood} | {warned} "
            f"| {each.off:.2f} m | {each.said.replace('|', '/')} | {verdict} |"
        )
    return "\n".join(lines) + "\n"


def _robots(after_s: Sequence[float], robots: int) -> str:
    """Return how many robots did something, and the first's and the last's time, s."""
    words = f"{len(after_s)} of {robots}"
    return f"{words}, {min(after_s):.0f} to {max(after_s):.0f} s" if after_s else words


def seconds_of(seeds: Sequence[int]) -> float:
    """Return how long the runs of one lie take, s of the bench's clock."""
    return len(seeds) * _DURATION_S
