"""The figures of ``bench --json`` for a run of either fleet."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any, Protocol

from maps.map_folder import MapFolder
from robot_agent.config import AgentConfig
from tools.bench.bench_fault import BenchFault, fault_figures
from tools.bench.stand_log import StandLog
from tools.metrics.metrics import RobotRun, bench_figures
from tools.metrics.wreck import Wreck
from tools.simulation.world import World


class BenchedFleet(Protocol):
    """A fleet after its run."""

    folder: MapFolder
    config: AgentConfig
    seed: int
    faults: tuple[BenchFault, ...]
    world: World

    def wrecks(self) -> list[Wreck]:
        """Return the robots that are stopped permanently."""


def robot_figures(
    name: str, world: World, index: int, stand: StandLog | None = None
) -> dict[str, Any]:
    """Return a robot's first stand with a reason, warnings, and contacts by what it touched.

    index: of its body in the world.
    """
    return {
        "robot": name,
        "stood_s": stand.stood_s if stand else None,
        "said": stand.said if stand else None,
        "warned_s": dict(stand.warned_s) if stand else {},
        "collisions_with": dict(Counter(world.contact_kinds(index))),
    }


def bench_result(
    fleet: BenchedFleet, runs: Sequence[RobotRun], duration: float, wall: float
) -> dict[str, Any]:
    """Return the figures of a run of ``duration`` s that took ``wall`` s of real time."""
    border, speed = fleet.folder.border, fleet.config.patrol.patrol_speed
    assert border is not None
    return {
        "robots": len(runs),
        "seed": fleet.seed,
        "duration_s": duration,
        "wall_s": wall,
        "faults": fault_figures(fleet.faults),
        **bench_figures(border, runs, fleet.world.contacts, speed, fleet.wrecks()),
    }
