"""Faults of a bench run: kind, robot, start and end."""

from __future__ import annotations

import math
import re
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from drivers.emulation.fault_plan import FaultPlan
from drivers.emulation.line_faults import LineFaults
from maps.map_folder import MapFolder
from maps.pose import Pose
from tools.metrics.wreck import Wreck
from tools.simulation.rig import RobotRig
from tools.simulation.start_poses import free_start_poses

CARRIED_M = 0.5
CARRY_ROOM_M = 0.5
"""Clearance needed at a place to which a robot is carried aside, m."""
NOISE = 0.2
"""Share of corrupt packets and telegrams on a noisy line."""
AWAY_M = 3.0
_ALONE_M = 1.5  # from all others, at a random place
_PLACES = 6  # drawn at a time

_TIME = r"\d+\.?\d*"
_SPEC = re.compile(
    rf"(?P<robot>\w+):(?P<kind>\w+)@(?P<start>{_TIME})(?:\.\.(?P<latest>{_TIME}))?"
    rf"(?:-(?P<end>{_TIME})|\+(?P<lasts>{_TIME}))?"
)
_ANY = re.compile(r"any(?P<count>[1-9]\d*)")
_REMEDY = (
    "write ROBOT:KIND@START, START-END or START+LASTING, in s, START a time or FIRST..LATEST for "
    "one drawn at random, ROBOT a name or any2 for two drawn at random, and KIND one of "
)


class BenchFaultError(ValueError):
    """An invalid fault; the message shows the syntax."""


class FaultKind(StrEnum):
    """Kind of a fault."""

    DEAD = "dead"  # the agent neither receives nor sends, as if killed or frozen
    BLIND = "blind"  # no byte from the laser arrives
    DEAF = "deaf"  # no byte from the base arrives
    STUCK = "stuck"  # the wheels do not turn
    NOISY = "noisy"  # a share of the packets and telegrams of both devices is corrupt
    CARRIED = "carried"  # moved once half a metre to its left, if there is room
    AWAY = "away"  # moved once to a random pose


_ONCE = (FaultKind.CARRIED, FaultKind.AWAY)


@dataclass(frozen=True, slots=True)
class BenchFault:
    """One fault of one robot, from start to end (s, virtual; inf: permanent)."""

    robot: str
    kind: FaultKind
    start: float
    end: float = math.inf

    def holds(self, t: float) -> bool:
        """Whether the fault is active at t."""
        return self.start <= t < self.end

    @property
    def is_permanent(self) -> bool:
        """Whether the robot stands permanently: it becomes a wreck."""
        return math.isinf(self.end) and self.kind not in _ONCE


def wrecks_of(faults: Sequence[BenchFault], poses: Mapping[str, Pose], t: float) -> list[Wreck]:
    """Return the robots that faults have stopped permanently by t, at their poses by name."""
    since: dict[str, float] = {}
    for fault in faults:
        if fault.is_permanent and fault.holds(t):
            since[fault.robot] = min(fault.start, since.get(fault.robot, math.inf))
    return [Wreck(poses[name].x, poses[name].y, name, start) for name, start in since.items()]


def parse_fault(text: str) -> BenchFault:
    """Parse a fault without random parts: ``robot2:dead@120``, ``robot1:blind@60-90`` (s).

    Raises BenchFaultError.
    """
    (fault,) = draw_faults([text], [], seed=0)
    return fault


def draw_faults(texts: Sequence[str], team: Sequence[str], seed: int) -> list[BenchFault]:
    """Parse faults as ``parse_fault`` does, also ``any2:dead@60..300`` with robots and times drawn
    from a seed, no robot twice.

    Raises BenchFaultError.
    """
    rng = np.random.default_rng((seed, _FAULT_STREAM))
    order = [team[index] for index in rng.permutation(len(team))]
    faults: list[BenchFault] = []
    for text in texts:
        match = _SPEC.fullmatch(text)
        if match is None or match["kind"] not in set(FaultKind):
            raise BenchFaultError(f"fault {text!r} is none: {_REMEDY}{', '.join(FaultKind)}")
        anybody = _ANY.fullmatch(match["robot"])
        count = int(anybody["count"]) if anybody else 1
        if anybody and count > len(order):
            raise BenchFaultError(f"fault {text!r}: there are not so many robots; name fewer")
        names = [order.pop() for _ in range(count)] if anybody else [match["robot"]]
        faults += [_drawn(text, match, name, rng) for name in names]
    return faults


_FAULT_STREAM = 17  # separates the random draws of faults from those of starts


def _drawn(text: str, match: re.Match[str], robot: str, rng: np.random.Generator) -> BenchFault:
    start = float(match["start"])
    if match["latest"] is not None:
        start = round(rng.uniform(start, max(start, float(match["latest"]))), 2)
    end = math.inf
    if match["end"] is not None:
        end = float(match["end"])
    elif match["lasts"] is not None:
        end = start + float(match["lasts"])
    if end <= start:
        raise BenchFaultError(
            f"fault {text!r} ends before it starts: {_REMEDY}{', '.join(FaultKind)}"
        )
    return BenchFault(robot, FaultKind(match["kind"]), start, end)


def check_robots(faults: Sequence[BenchFault], names: Sequence[str]) -> None:
    """Raise BenchFaultError if a fault names a robot that is not in the team."""
    for fault in faults:
        if fault.robot not in names:
            raise BenchFaultError(
                f"fault of {fault.robot}: there is no such robot, the team is {', '.join(names)}"
            )


def fault_figures(faults: Sequence[BenchFault]) -> list[dict[str, Any]]:
    """Return the faults for ``bench --json``; end None means permanent."""
    return [
        {
            "robot": fault.robot,
            "kind": str(fault.kind),
            "start": fault.start,
            "end": fault.end if fault.end < math.inf else None,
        }
        for fault in faults
    ]


class FaultInjector:
    """Applies the faults of one robot as time passes."""

    def __init__(
        self, faults: Sequence[BenchFault], rig: RobotRig, folder: MapFolder, seed: int
    ) -> None:
        """Put fault-injecting lines between a robot's devices and its agent."""
        self._rng = np.random.default_rng(seed)
        self.base = LineFaults(rig.base, FaultPlan(), self._rng)
        self.laser = LineFaults(rig.laser, FaultPlan(), self._rng)
        self._rig = rig
        self._folder = folder
        self._pending = deque(sorted(faults, key=lambda fault: fault.start))
        self._active: list[BenchFault] = []
        self.agent_dead = False
        """Whether the agent neither receives nor sends."""

    def advance(self, t: float) -> None:
        """Begin and end the faults that are due at t."""
        while self._pending and self._pending[0].start <= t:
            fault = self._pending.popleft()
            self._active.append(fault)
            if fault.kind is FaultKind.CARRIED:
                self._move_aside()
            elif fault.kind is FaultKind.AWAY:
                self._rig.place(self._random_place())
        self._active = [fault for fault in self._active if fault.holds(t)]
        on = {fault.kind for fault in self._active}
        self.agent_dead = FaultKind.DEAD in on
        self.base.mute = self.agent_dead or FaultKind.DEAF in on
        self.laser.mute = self.agent_dead or FaultKind.BLIND in on
        self.base.spoilt = self.laser.spoilt = NOISE if FaultKind.NOISY in on else 0.0
        self._rig.stuck = FaultKind.STUCK in on

    def _move_aside(self) -> None:
        """Move the robot CARRIED_M to its left if there is room."""
        pose = self._rig.body.pose
        left = pose.compose(Pose(0.0, CARRIED_M, 0.0))
        directions = np.linspace(0.0, math.tau, 16, endpoint=False)
        walls = self._rig.world.free_ways(left.x, left.y, directions).min()
        way = self._rig.world.free_way(pose.x, pose.y, pose.theta + math.pi / 2.0)
        others = [body for body in self._rig.world.bodies if body is not self._rig.body]
        apart = min((math.dist(left[:2], body.pose[:2]) for body in others), default=math.inf)
        if min(walls, way - CARRIED_M) > CARRY_ROOM_M and apart > 2.0 * CARRY_ROOM_M:
            self._rig.place(left)

    def _random_place(self) -> Pose:
        """Return a random pose off the border, away from the present one and from other robots."""
        folder, here = self._folder, self._rig.body.pose
        assert folder.border is not None, "robots patrol a border"
        others = [body.pose for body in self._rig.world.bodies if body is not self._rig.body]
        while True:
            for pose in free_start_poses(
                folder.map, folder.border, _PLACES, self._rng, self._rig.body.reach
            ):
                alone = all(math.dist(pose[:2], other[:2]) > _ALONE_M for other in others)
                if alone and math.dist(pose[:2], here[:2]) > AWAY_M:
                    return pose

    def discard_output(self, t: float) -> None:
        """Discard what the devices have sent by t."""
        self.base.pop_output(t)
        self.laser.pop_output(t)
