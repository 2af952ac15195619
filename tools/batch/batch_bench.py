"""The figures of ``bench --json`` for every run of a batch."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from maps.map_folder import MapFolder
from robot_agent.config import AgentConfig
from tools.batch.all_knowing import ROLLOUTS, detections
from tools.batch.arrays import Flags
from tools.batch.batch import Batch
from tools.batch.situations import ACTIONS
from tools.bench.bench_fault import BenchFault
from tools.bench.bench_result import bench_result, robot_figures
from tools.bench.perception_log import PerceptionLog
from tools.metrics.metrics import ARRIVED_M, RobotRun
from tools.metrics.wreck import Wreck
from tools.simulation.world import World

MOMENTS = 4
"""Moments of a run, evenly spaced, at which the intruder who sees all strikes."""


def run_batch(
    batch: Batch,
    duration: float,
    *,
    moments: int = 0,
    since: float = 0.0,
    rollouts: int = ROLLOUTS,
    progress: Callable[[float], None] = lambda _: None,
) -> list[dict[str, Any]]:
    """Run a batch for a duration, s, virtual; return the figures of ``bench --json`` of each run.

    moments: at which ``intruder_seen.all_knowing`` is found, by so many rollouts; 0 for none. Those
    before ``since``, s, are left out.
    """
    started = time.perf_counter()
    log, struck = BatchLog(batch), _Strikes(batch, rollouts)
    evenly = ((number + 0.5) / moments * duration for number in range(moments))
    strikes = [t for t in evenly if t >= since]
    while batch.t < duration:
        batch.step()
        log.sample()
        struck.watch()
        if strikes and batch.t >= strikes[0]:
            strikes.pop(0)
            struck.strike()
        progress(batch.t)
    wall = (time.perf_counter() - started) / len(batch.seeds)
    return [_figures(batch, run, log, struck, duration, wall) for run in range(len(batch.seeds))]


@dataclass(eq=False)
class _BatchedRun:
    """One run of a batch, as a fleet after its run."""

    folder: MapFolder
    config: AgentConfig
    seed: int
    faults: tuple[BenchFault, ...]
    world: World
    left: list[Wreck]

    def wrecks(self) -> list[Wreck]:
        return self.left


def _figures(
    batch: Batch, run: int, log: BatchLog, struck: _Strikes, duration: float, wall: float
) -> dict[str, Any]:
    world = batch.bodies.world(run)
    fleet = _BatchedRun(
        batch.folder,
        batch.config,
        batch.seeds[run],
        batch.faults[run],
        world,
        batch.wrecks(run),
    )
    border = batch.folder.border
    assert border is not None
    figures = {
        "sensing": "ideal",
        "truth": "ideal",
        **bench_result(fleet, log.runs(run), duration, wall),
        "strangers": 0,
        "each": [robot_figures(name, world, index) for index, name in enumerate(batch.names)],
        "perception": PerceptionLog(world, border).figures(),  # empty
        "gate_stops": batch.gate_stops(run),
    }
    for place, since in ((figures, 0.0), (figures["settled"], duration / 2.0)):
        if struck.times and place["intruder_seen"] is not None:
            place["intruder_seen"]["all_knowing"] = struck.mean(run, since)
    return figures


class BatchLog:
    """Samples the true positions and the decisions of all robots of a batch."""

    def __init__(self, batch: Batch) -> None:
        self._batch = batch
        self._times: list[float] = []
        self._rows: list[tuple[np.ndarray, ...]] = []

    def sample(self) -> None:
        """Append every robot's true position and decision in force."""
        batch, made = self._batch, self._batch.decisions
        assert made is not None, "the batch has taken a step"
        dead = batch.dead
        action = np.where(dead, len(ACTIONS), made.action).astype(np.int8)
        direction = np.where(dead, 0, made.direction).astype(np.int8)
        self._times.append(batch.t)
        self._rows.append((batch.bodies.x, batch.bodies.y, action, direction))

    def runs(self, run: int) -> list[RobotRun]:
        """Return the samples of a run, one per robot."""
        t, names = np.array(self._times), [*(str(action) for action in ACTIONS), ""]
        own = slice(run * self._batch.robots, (run + 1) * self._batch.robots)
        x, y, action, direction = (
            np.array([row[part][own] for row in self._rows]).T for part in range(4)
        )
        return [
            RobotRun(
                name=name,
                t=t,
                position=np.column_stack((x[index], y[index])),
                action=[names[code] for code in action[index].tolist()],
                direction=np.ascontiguousarray(direction[index]),
            )
            for index, name in enumerate(self._batch.names)
        ]


class _Strikes:
    """Probabilities of detection of the intruder who sees all, at some moments of each run."""

    def __init__(self, batch: Batch, rollouts: int) -> None:
        self._batch = batch
        self._rollouts = rollouts
        self._reached: Flags = np.zeros(batch.n, dtype=np.bool_)
        self.times: list[float] = []
        self._found: list[list[dict[str, float] | None]] = []

    def watch(self) -> None:
        """Note which robots have reached the border by now."""
        made = self._batch.decisions
        assert made is not None
        self._reached |= made.distance <= ARRIVED_M

    def strike(self) -> None:
        """Find the probabilities now; none in a run in which a robot has not reached the border."""
        by_run = (self._reached | self._batch.dead).reshape(-1, self._batch.robots)
        whole = [bool(reached.all()) for reached in by_run]
        found = detections(self._batch, self._rollouts)
        self.times.append(self._batch.t)
        self._found.append([each if whole[run] else None for run, each in enumerate(found)])

    def mean(self, run: int, since: float) -> dict[str, float] | None:
        """Return the means of a run over the moments since a time, s; None if there are none."""
        found = [row[run] for t, row in zip(self.times, self._found, strict=True) if t >= since]
        known: Sequence[dict[str, float]] = [each for each in found if each is not None]
        if not known:
            return None
        return {dwell: float(np.mean([each[dwell] for each in known])) for dwell in known[0]}
