"""Faults of a bench run: what goes wrong, with which robot, from when until when."""

from __future__ import annotations

import math
import re
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from maps.pose import Pose
from tools.bench.faulty_line import FaultyLine
from tools.bench.rig import RobotRig

CARRIED_M = 0.5
CARRY_ROOM_M = 0.5
"""Left free beside the place where a robot is put down, if it is carried at all."""
NOISE = 0.2
"""Share of corrupt packets on a noisy line."""

_SPEC = re.compile(r"(?P<robot>\w+):(?P<kind>\w+)@(?P<start>\d+\.?\d*)(?:-(?P<end>\d+\.?\d*))?")


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
        return math.isinf(self.end) and self.kind is not FaultKind.CARRIED


def parse_fault(text: str) -> BenchFault:
    """Read ``robot2:dead@120`` or ``robot1:blind@60-90`` (s).

    Raises BenchFaultError.
    """
    match = _SPEC.fullmatch(text)
    remedy = (
        "write ROBOT:KIND@START or ROBOT:KIND@START-END, in s, with KIND one of "
        f"{', '.join(FaultKind)}"
    )
    if match is None or match["kind"] not in set(FaultKind):
        raise BenchFaultError(f"fault {text!r} is none: {remedy}")
    start = float(match["start"])
    end = math.inf if match["end"] is None else float(match["end"])
    if end <= start:
        raise BenchFaultError(f"fault {text!r} ends before it starts: {remedy}")
    return BenchFault(match["robot"], FaultKind(match["kind"]), start, end)


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

    def __init__(self, faults: Sequence[BenchFault], rig: RobotRig, seed: int) -> None:
        """Put lines that can fail between a robot's devices and its agent."""
        rng = np.random.default_rng(seed)
        self.base = FaultyLine(rig.base, rng)
        self.laser = FaultyLine(rig.laser, rng)
        self._rig = rig
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
                self._carry()
        self._present = [fault for fault in self._present if fault.holds(t)]
        on = {fault.kind for fault in self._present}
        self.agent_dead = FaultKind.DEAD in on
        self.base.mute = self.agent_dead or FaultKind.DEAF in on
        self.laser.mute = self.agent_dead or FaultKind.BLIND in on
        self.base.corrupt = self.laser.corrupt = NOISE if FaultKind.NOISY in on else 0.0
        self._rig.stuck = FaultKind.STUCK in on

    def _carry(self) -> None:
        pose = self._rig.body.pose
        left = pose.compose(Pose(0.0, CARRIED_M, 0.0))
        directions = np.linspace(0.0, math.tau, 16, endpoint=False)
        walls = self._rig.world.free_ways(left.x, left.y, directions).min()
        way = self._rig.world.free_way(pose.x, pose.y, pose.theta + math.pi / 2.0)
        others = [body for body in self._rig.world.bodies if body is not self._rig.body]
        apart = min((math.dist(left[:2], body.pose[:2]) for body in others), default=math.inf)
        if min(walls, way - CARRIED_M) > CARRY_ROOM_M and apart > 2.0 * CARRY_ROOM_M:
            self._rig.carry_left(CARRIED_M)

    def lose_output(self, t: float) -> None:
        """Let go what the devices have sent by t to nobody."""
        self.base.take_output(t)
        self.laser.take_output(t)
