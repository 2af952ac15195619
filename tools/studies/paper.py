"""The paper's experiment: three robots on its 51 m border; checks the paper's claims.

The robots start far from the border, as the paper's did. The claims (section III): first they reach
the frontier; on the border the distance stays small; one robot's change to Patrol CW coincides with
the other's to Patrol CCW; afterwards both keep going, apart.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from maps.map_folder import MapFolder, load_map_folder
from maps.pose import Pose
from robot_agent.config import AgentConfig
from robot_agent.patrol.actions import Action
from tools.bench.fleet import Fleet, FleetLog, run_bench
from tools.bench.ideal_fleet import IdealFleet, IdealLog, run_ideal_bench
from tools.bench.sensing import Sensing
from tools.metrics.metrics import Meeting, RobotRun, meetings
from tools.simulation.rig import outline_of
from tools.simulation.start_poses import StartPoseError, free_start_poses
from tools.simulation.truth.truth import Truth, load_truth
from tools.studies.worker_pool import worker_pool

MAP, BORDER, ROBOTS, DURATION_S = "paper_lab", "border", 3, 1800.0
P99_M, MAX_M = 0.05, 0.10
STEPS = 2
"""Control steps between the turns of two robots up to which they count as simultaneous."""
FAR_M = (2.2, math.inf)
"""Distances from the border, m, between which the robots start: where it is certainly far."""
_REACTION_S = 12.0  # to turn after coming within sight, or to keep going again after turning

_TURNS = (Action.PATROL_CLOCKWISE, Action.PATROL_COUNTER_CLOCKWISE)


@dataclass(frozen=True)
class Turn:
    """A head-on meeting of two robots and its outcome by the paper's claims.

    steps_apart: control steps between the two robots' turns, None if not both turned.
    opposite: one changed to Patrol CW, the other to Patrol CCW. parted: both kept going afterwards,
    in opposite directions. closest_m: smallest distance of the centres.
    """

    t: float
    robots: tuple[str, str]
    steps_apart: int | None
    opposite: bool
    parted: bool
    closest_m: float


@dataclass(frozen=True, eq=False)
class PaperRun:
    """One run of the experiment."""

    folder: MapFolder
    runs: list[RobotRun]
    figures: dict[str, Any]

    @property
    def meetings(self) -> list[Meeting]:
        """All meetings that ended within the run."""
        border = self.folder.border
        assert border is not None, "the experiment runs on a border"
        return [meeting for meeting in meetings(border, self.runs) if meeting.parted]


@dataclass(frozen=True)
class PaperTrial:
    """Settings of the experiment, without the seed."""

    map_folder: Path
    border: str
    sensing: Sensing
    duration: float
    """Simulated time, s."""
    config: AgentConfig = field(default_factory=AgentConfig)
    """Configuration of every robot."""
    truth: Truth = field(default_factory=lambda: load_truth("plain"))
    """What the robots and their world really are; ideal sensing has none."""


def run_seeds(trial: PaperTrial, seeds: Sequence[int], jobs: int) -> Iterator[PaperRun]:
    """Run the experiment with every seed, ``jobs`` processes at a time; yield in the seeds' order.

    Raises MapError, BorderError for a map or border that cannot be used.
    """
    if jobs == 1:
        yield from (run_paper(trial, seed) for seed in seeds)
        return
    with worker_pool(jobs) as pool:
        yield from pool.map(partial(run_paper, trial), seeds)


def run_paper(trial: PaperTrial, seed: int) -> PaperRun:
    """Run the experiment once.

    Raises MapError, BorderError for a map or border that cannot be used.
    """
    folder = load_map_folder(trial.map_folder, trial.border)
    starts = far_starts(folder, seed, outline_of(trial.truth.robot).reach)
    if trial.sensing is Sensing.IDEAL:
        ideal = IdealFleet(folder, ROBOTS, seed, trial.config, starts)
        ideal_log = IdealLog(ideal)
        figures = run_ideal_bench(ideal, trial.duration, log=ideal_log)
        return PaperRun(folder, ideal_log.runs(), figures)
    fleet = Fleet(folder, ROBOTS, seed, trial.config, starts, truth=trial.truth)
    log = FleetLog(fleet)
    figures = run_bench(fleet, trial.duration, log=log)
    return PaperRun(folder, log.runs(), figures)


def far_starts(folder: MapFolder, seed: int, reach: float) -> list[Pose]:
    """Return the robots' start poses: far from the border, or where the map has room for them.

    reach: m from base_link to a robot's farthest corner.
    """
    assert folder.border is not None, "the experiment runs on a border"
    rng = np.random.default_rng(seed)
    try:
        return free_start_poses(folder.map, folder.border, ROBOTS, rng, reach, FAR_M)
    except StartPoseError:
        return free_start_poses(folder.map, folder.border, ROBOTS, rng, reach)


def turns(run: PaperRun) -> list[Turn]:
    """Return every head-on meeting of two robots in Keep Going with its outcome."""
    by_name = {each.name: each for each in run.runs}
    found = [_turn(by_name, meeting) for meeting in run.meetings]
    return [turn for turn in found if turn is not None]


def _turn(by_name: dict[str, RobotRun], meeting: Meeting) -> Turn | None:
    """Return a meeting's outcome; None unless both robots were in Keep Going, head-on.

    Others: one is turning from a third robot, or has just reversed at random.
    """
    pair = [by_name[name] for name in meeting.robots]
    start = int(np.searchsorted(pair[0].t, meeting.t))
    turned = [_first_index(run, start, _TURNS) for run in pair]
    first = min((index for index in turned if index is not None), default=None)
    if first is None or first == 0:
        return None
    before = [(run.action[first - 1], int(run.direction[first - 1])) for run in pair]
    if {action for action, _ in before} != {Action.KEEP_GOING} or before[0] == before[1]:
        return None
    one, other = turned
    if one is None or other is None:
        return Turn(meeting.t, meeting.robots, None, False, False, meeting.closest_m)
    after = [
        int(run.direction[_first_index(run, since, (Action.KEEP_GOING,)) or since])
        for run, since in zip(pair, (one, other), strict=True)
    ]
    return Turn(
        t=meeting.t,
        robots=meeting.robots,
        steps_apart=abs(one - other),
        opposite={pair[0].action[one], pair[1].action[other]} == set(_TURNS),
        parted=sorted(after) == [-1, 1],
        closest_m=meeting.closest_m,
    )


def _first_index(run: RobotRun, start: int, actions: Sequence[str]) -> int | None:
    """Return the index of the first of some actions within _REACTION_S; None if there is none."""
    end = int(np.searchsorted(run.t, run.t[start] + _REACTION_S))
    return next((i for i in range(start, end) if run.action[i] in actions), None)


def claims(run: PaperRun) -> dict[str, Any]:
    """Return the measured figures of a run and whether each of the paper's claims held."""
    found, distance = turns(run), run.figures["border_distance_m"]
    both = [turn for turn in found if turn.steps_apart is not None]
    paired = [turn for turn in both if turn.opposite and turn.parted]
    at_once = [turn for turn in paired if (turn.steps_apart or 0) <= STEPS]
    held = {
        "first_reach_frontier": all(map(_first_reaches_frontier, run.runs)),
        "p99_below_0.05_m": distance["p99"] is not None and distance["p99"] < P99_M,
        "never_above_0.10_m": distance["max"] is not None and distance["max"] < MAX_M,
        "every_meeting_cw_and_ccw_then_apart": len(paired) == len(found),
        "every_turn_within_two_steps": len(at_once) == len(found),
        "no_contact": run.figures["contacts"] == 0,
    }
    return {
        "sensing": run.figures["sensing"],
        "seed": run.figures["seed"],
        "duration_s": run.figures["duration_s"],
        "border_distance_m": distance,
        "contacts": run.figures["contacts"],
        "closest_m": run.figures["closest_m"],
        "meetings": {
            "head_on": len(found),
            "cw_and_ccw_then_apart": len(paired),
            "within_two_steps": len(at_once),
            "max_steps_apart": max((turn.steps_apart or 0 for turn in both), default=0),
        },
        "held": held,
        "turns": [asdict(turn) for turn in found],
    }


def _first_reaches_frontier(run: RobotRun) -> bool:
    """Return whether a robot's first action is Reach Frontier."""
    return next((action for action in run.action if action), "") == Action.REACH_FRONTIER


def over_seeds(claimed: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return the claims of all seeds (one or more) in one: worst figures, claims held by all."""
    distances = [each["border_distance_m"] for each in claimed]
    counts = ("head_on", "cw_and_ccw_then_apart", "within_two_steps")
    return {
        "sensing": claimed[0]["sensing"],
        "seeds": [each["seed"] for each in claimed],
        "duration_s": claimed[0]["duration_s"],
        "border_distance_m": {
            "worst_p99": _worst(distance["p99"] for distance in distances),
            "worst_max": _worst(distance["max"] for distance in distances),
            "p99_by_seed": [distance["p99"] for distance in distances],
        },
        "contacts": sum(each["contacts"] for each in claimed),
        "closest_m": min(
            (each["closest_m"] for each in claimed if each["closest_m"] is not None), default=None
        ),
        "meetings": {
            **{name: sum(each["meetings"][name] for each in claimed) for name in counts},
            "max_steps_apart": max(each["meetings"]["max_steps_apart"] for each in claimed),
        },
        "held": {name: all(each["held"][name] for each in claimed) for name in claimed[0]["held"]},
    }


def _worst(values: Iterable[float | None]) -> float | None:
    return max((value for value in values if value is not None), default=None)
