"""What one SIP says about the robot, in SI units."""

from __future__ import annotations

from dataclasses import dataclass

from drivers.p2os.model import RobotModel
from drivers.p2os.odometer import Odometer
from drivers.p2os.sip import Sip


@dataclass(frozen=True, slots=True)
class BaseState:
    """One report of the base, at the time it was measured.

    ``x``, ``y``, ``theta`` are in the odom frame, continuous across counter wraps and new
    sessions; theta is not wrapped. Bit 0 of a bumper mask is the ring's first segment.
    ``sonar`` holds (transducer number, range in m) of the readings new since the last report.
    """

    t: float  # s
    x: float  # m
    y: float  # m
    theta: float  # rad
    v: float  # m/s, from the wheels
    w: float  # rad/s, from the wheels
    v_left: float  # m/s
    v_right: float  # m/s
    battery: float  # V
    stall_left: bool
    stall_right: bool
    front_bumpers: int
    rear_bumpers: int
    motors_enabled: bool
    sonar_on: bool
    flags: int
    sonar: tuple[tuple[int, float], ...]

    @property
    def standing(self) -> bool:
        """Whether both wheels report rest, to within 10 mm/s."""
        return abs(self.v_left) < 0.01 and abs(self.v_right) < 0.01


def base_state(t: float, sip: Sip, odometer: Odometer, model: RobotModel) -> BaseState:
    """Convert a SIP by the model's factors; ``odometer`` has already followed its counters."""
    conversion = model.conversion
    v_left = sip.left_speed_counts * conversion.speed
    v_right = sip.right_speed_counts * conversion.speed
    decivolts = sip.tail.battery_decivolts
    left, right = sip.left_stall_byte, sip.right_stall_byte
    return BaseState(
        t,
        odometer.x,
        odometer.y,
        odometer.theta,
        0.5 * (v_left + v_right),
        0.5 * (v_right - v_left) * conversion.turn,
        v_left,
        v_right,
        0.1 * (sip.battery_decivolts if decivolts is None else decivolts),
        bool(left & 1),
        bool(right & 1),
        right >> 1,
        left >> 1,
        sip.motors_enabled,
        sip.sonar_on,
        sip.flags,
        tuple([(number, counts * conversion.range) for number, counts in sip.sonar]),
    )
