"""What an emulated base is: its limits and what its counts mean, as its FLASH holds them.

The driver's models are not read here: an emulated robot may be another one than its client thinks.
The layout of packets and the numbers of commands are the protocol's, and both sides share them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class BaseMake:
    """One make of base. The values of counts are SI values of one."""

    subclass: str
    top_speed: float  # m/s
    top_turn_rate_deg: float  # deg/s
    transducers: int  # of the sonar rings
    sonar_far: float  # m, sent by a transducer without an echo
    bumper_segments: tuple[int, int]  # of the front and the rear ring, as CONFIG states
    battery: float  # V, nominal
    heading_counts: int  # per turn
    distance_count: float  # m, of x or y
    speed_count: float  # m/s, of a wheel
    range_count: float  # m, of a sonar
    wheel_speed_count: float  # m/s, of VEL2
    turn: float  # rad/s per m/s of half the wheels' speed difference: 1 / half track

    @property
    def top_turn_rate(self) -> float:
        """Fastest turn, rad/s."""
        return math.radians(self.top_turn_rate_deg)


PIONEER_2DX = BaseMake(
    subclass="p2dx",
    top_speed=2.2,
    top_turn_rate_deg=500.0,
    transducers=16,
    sonar_far=5.0,
    bumper_segments=(5, 5),
    battery=12.0,
    heading_counts=4096,
    distance_count=0.00084,
    speed_count=0.001,
    range_count=0.000268,
    wheel_speed_count=0.02,
    turn=5.6,
)
"""Source: ARIA's p2dx.p (DistConvFactor, VelConvFactor, RangeConvFactor, DiffConvFactor,
Vel2Divisor, AngleConvFactor, NumFrontBumpers, TransVelMax, RotVelMax)."""
