"""Selects the bench: with every byte, or the decision layer alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import StrEnum
from typing import Any

from maps.map_folder import MapFolder
from robot_agent.config import AgentConfig
from tools.bench.bench_fault import BenchFault
from tools.bench.fleet import Fleet, run_bench
from tools.bench.ideal_fleet import IdealFleet, run_ideal_bench
from tools.simulation.lockstep import Observer
from tools.simulation.truth.truth import Truth


class Sensing(StrEnum):
    """Kind of sensing."""

    BYTES = "bytes"  # the real agents; every byte encoded and decoded; noise
    IDEAL = "ideal"  # true poses and positions of teammates


def bench(
    sensing: Sensing,
    folder: MapFolder,
    robots: int,
    seed: int,
    duration: float,
    *,
    config: AgentConfig | None = None,
    faults: Sequence[BenchFault] = (),
    observer: Callable[[str, AgentConfig], Observer] | None = None,
    strangers: int = 0,
    cameras: bool = False,
    truth: Truth | None = None,
    tight: bool = False,
    progress: Callable[[float], None] = lambda _: None,
) -> dict[str, Any]:
    """Run robots from seeded starts for a duration, s; return the figures of ``bench --json``.

    observer: makes the receiver of a robot's events and effects; ideal sensing has neither.
    strangers, cameras, truth, tight: as for ``Fleet``; ideal sensing has none.
    Raises BenchFaultError and StartPoseError.
    """
    if sensing is Sensing.IDEAL:
        ideal = IdealFleet(folder, robots, seed, config, faults=faults)
        return run_ideal_bench(ideal, duration, progress)
    fleet = Fleet(
        folder,
        robots,
        seed,
        config,
        observer=observer,
        faults=faults,
        strangers=strangers,
        cameras=cameras,
        truth=truth,
        tight=tight,
    )
    return run_bench(fleet, duration, progress)
