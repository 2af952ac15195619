"""Faults of a bench run: what goes wrong, with which robot, from when until when."""

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
"""Left free beside the place where a robot is put down, if it is carried at all."""
NOISE = 0.2
"""Share of corrupt packets on a noisy line."""
AWAY_M = 3.0
_ALONE_M = 1.5  # from all others, where a robot is put down
_PLACES = 6  # looked at for it

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
    """A fault that cannot be set up; the message shows how one is written."""


class FaultKind(StrEnum):
    """What goes wrong."""

    DEAD = "dead"  # the agent does nothing, as when killed or frozen
    BLIND = "blind"  # nothing of what the laser sends arrives
    DEAF = "deaf"  # nothing of what the base sends arrives
    STUCK = "stuck"  # the wheels do not turn
    NOISY = "noisy"  # a share of the packets and telegrams of both devices is corrupt
    CARRIED = "carried"  # once, half a metre to its left, if there is room
    AWAY = "away"  # once, somebody puts the robot elsewhere, turned anyhow: it is lost


_ONCE = (FaultKind.CARRIED, FaultKind.AWAY)


@dataclass(frozen=True, slots=True)
class BenchFault:
    """One fault of one robot, from start to end (s, virtual; inf: for good)."""

    robot: str
    kind: FaultKind
    start: float
    end: float = math.inf

    def holds(self, t: float) -> bool:
        """Tell whether the fault is on at t."""
        return self.start <= t < self.end

    @property
    def makes_wreck(self) -> bool:
        """Whether the robot stands still for good."""
        return math.isinf(self.end) and self.kind not in _ONCE


def wrecks_of(faults: Sequence[BenchFault], poses: Mapping[str, Pose], t: float) -> list[Wreck]:
    """Return the robots, by name at their poses, that faults have stopped for good by t."""
    since: dict[str, float] = {}
    for fault in faults:
        if fault.makes_wreck and fault.holds(t):
            since[fault.robot] = min(fault.start, since.get(fault.robot, math.inf))
    return [Wreck(poses[name].x, poses[name].y, name, start) for name, start in since.items()]


def parse_fault(text: str) -> BenchFault:
    """Read a fault that leaves nothing to chance: ``robot2:dead@120``, ``robot1:blind@60-90`` (s).

    Raises BenchFaultError.
    """
    (fault,) = draw_faults([text], [], seed=0)
    return fault


def draw_faults(texts: Sequence[str], team: Sequence[str], seed: int) -> list[BenchFault]:
    """Read faults as ``parse_fault`` does, also ``any2:dead@60..300``: robots and times that a
    seed draws, no robot twice.

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


_FAULT_STREAM = 17  # keeps the draws of faults apart from those of starts


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
    """Raise BenchFaultError for a fault of a robot that is not among the names of the team."""
    for fault in faults:
        if fault.robot not in names:
            raise BenchFaultError(
                f"fault of {fault.robot}: there is no such robot, the team is {', '.join(names)}"
            )


def fault_figures(faults: Sequence[BenchFault]) -> list[dict[str, Any]]:
    """Return the faults as ``bench --json`` tells them; end None: for good."""
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
    """Does to one robot what its faults say, as time passes."""

    def __init__(
        self, faults: Sequence[BenchFault], rig: RobotRig, folder: MapFolder, seed: int
    ) -> None:
        """Put lines that can fail between a robot's devices and its agent."""
        self._rng = np.random.default_rng(seed)
        self.base = LineFaults(rig.base, FaultPlan(), self._rng)
        self.laser = LineFaults(rig.laser, FaultPlan(), self._rng)
        self._rig = rig
        self._folder = folder
        self._to_come = deque(sorted(faults, key=lambda fault: fault.start))
        self._present: list[BenchFault] = []
        self.agent_dead = False
        """Whether nobody is there to hear the devices."""

    def advance(self, t: float) -> None:
        """Begin and end faults at t, s."""
        while self._to_come and self._to_come[0].start <= t:
            fault = self._to_come.popleft()
            self._present.append(fault)
            if fault.kind is FaultKind.CARRIED:
                self._carry_aside()
            elif fault.kind is FaultKind.AWAY:
                self._rig.place(self._elsewhere())
        self._present = [fault for fault in self._present if fault.holds(t)]
        on = {fault.kind for fault in self._present}
        self.agent_dead = FaultKind.DEAD in on
        self.base.mute = self.agent_dead or FaultKind.DEAF in on
        self.laser.mute = self.agent_dead or FaultKind.BLIND in on
        self.base.spoilt = self.laser.spoilt = NOISE if FaultKind.NOISY in on else 0.0
        self._rig.stuck = FaultKind.STUCK in on

    def _carry_aside(self) -> None:
        """Put the robot to its left if there is room."""
        pose = self._rig.body.pose
        left = pose.compose(Pose(0.0, CARRIED_M, 0.0))
        directions = np.linspace(0.0, math.tau, 16, endpoint=False)
        walls = self._rig.world.free_ways(left.x, left.y, directions).min()
        way = self._rig.world.free_way(pose.x, pose.y, pose.theta + math.pi / 2.0)
        others = [body for body in self._rig.world.bodies if body is not self._rig.body]
        apart = min((math.dist(left[:2], body.pose[:2]) for body in others), default=math.inf)
        if min(walls, way - CARRIED_M) > CARRY_ROOM_M and apart > 2.0 * CARRY_ROOM_M:
            self._rig.place(left)

    def _elsewhere(self) -> Pose:
        """Return a place to put the robot down at: off the border, away from here and others."""
        folder, here = self._folder, self._rig.body.pose
        assert folder.border is not None, "robots patrol a border"
        others = [body.pose for body in self._rig.world.bodies if body is not self._rig.body]
        while True:
            for pose in free_start_poses(folder.map, folder.border, _PLACES, self._rng):
                alone = all(math.dist(pose[:2], other[:2]) > _ALONE_M for other in others)
                if alone and math.dist(pose[:2], here[:2]) > AWAY_M:
                    return pose

    def lose_output(self, t: float) -> None:
        """Let go what the devices have sent by t to nobody."""
        self.base.pop_output(t)
        self.laser.pop_output(t)
