"""The content of one SIP in SI units."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

from drivers.p2os.fitted_bumpers import FittedBumpers
from drivers.p2os.model import RobotModel
from drivers.p2os.odometer import Odometer
from drivers.p2os.sip import SIP_MOVING, Sip

NO_TEMPERATURE = -127
"""This and -128 mean that the temperature is not measured."""
_MOST_OF_12 = 16.0  # V, of a 12 V lead-acid battery on any charger; ours


class ChargeState(IntEnum):
    """State of the charger, reported by later firmware."""

    UNKNOWN = -1  # a code that is not documented
    NOT_CHARGING = 0
    BULK = 1
    OVERCHARGE = 2
    FLOAT = 3
    BALANCE = 4


_CHARGE_CODES = range(max(ChargeState) + 1)


@dataclass(frozen=True, slots=True)
class BaseState:
    """One report of the base, with the time of its measurement.

    ``x``, ``y``, ``theta`` are in the odom frame, continuous across counter wraps and new
    sessions; theta is not wrapped. Bit 0 of a bumper mask is the ring's first segment; a ring
    that is not fitted is 0.
    ``sonar`` holds (transducer number, range in m) of the readings new since the last report.
    Fields that only later firmware reports are None, 0 or False with P2OS.
    """

    t: float
    x: float  # m
    y: float  # m
    theta: float  # rad
    v: float  # m/s, from the wheels
    w: float  # rad/s, from the wheels
    v_left: float  # m/s
    v_right: float  # m/s
    battery: float  # V, of all its blocks
    stall_left: bool  # not by the stop button, which later firmware reports as a stall too
    stall_right: bool
    front_bumpers: int
    rear_bumpers: int
    motors_enabled: bool
    sonar_on: bool
    flags: int
    sonar: tuple[tuple[int, float], ...]
    stop_button: bool = False  # as later firmware reports it; P2OS has no such flag
    moving: bool = False  # the controller's own flag
    charge_state: ChargeState | None = None  # None where the firmware does not report it
    charge: float | None = None  # 0 to 1
    fault_flags: int = 0
    temperature_celsius: int | None = None
    unknown_sonars: int = 0  # number of readings dropped: the model lacks the transducer
    turn_rate: float | None = None  # rad/s as the controller measures it, its gyro included
    charger_power: bool = False

    @property
    def charging(self) -> bool:
        """Whether the base reports a charger at work, or a state of it that is not documented."""
        return self.charge_state not in (None, ChargeState.NOT_CHARGING)

    @property
    def standing(self) -> bool:
        """Whether both wheels report less than 10 mm/s."""
        return abs(self.v_left) < 0.01 and abs(self.v_right) < 0.01


def base_state(
    t: float, sip: Sip, odometer: Odometer, model: RobotModel, bumpers: FittedBumpers
) -> BaseState:
    """Convert a SIP by the model's factors; ``odometer`` must be up to date with its counters."""
    conversion = model.conversion
    v_left = sip.left_speed_counts * conversion.speed
    v_right = sip.right_speed_counts * conversion.speed
    tail = sip.tail
    fitted = [reading for reading in sip.sonar if reading[0] < len(model.sonar)]
    front, rear = bumpers.pressed(sip)
    return BaseState(
        t,
        odometer.x,
        odometer.y,
        odometer.theta,
        0.5 * (v_left + v_right),
        0.5 * (v_right - v_left) * conversion.turn,
        v_left,
        v_right,
        _battery_volts(sip, model),
        bool(sip.left_stall_byte & 1) and not sip.stalled_by_button,
        bool(sip.right_stall_byte & 1) and not sip.stalled_by_button,
        front,
        rear,
        sip.motors_enabled,
        sip.sonar_on,
        sip.flags,
        tuple([(number, counts * conversion.range) for number, counts in fitted]),
        sip.stop_button,
        sip.packet_type == SIP_MOVING,
        _charge_state(tail.charge_state),
        None if tail.state_of_charge_percent is None else 0.01 * tail.state_of_charge_percent,
        tail.fault_flags or 0,
        _temperature(tail.temperature_celsius),
        len(sip.sonar) - len(fitted),
        _turn_rate(tail.turn_rate_decidegrees_s),
        sip.charger_power,
    )


def _battery_volts(sip: Sip, model: RobotModel) -> float:
    """Return the battery's voltage.

    Every SIP has it on the scale of a 12 V battery, later firmware adds the real one (ARIA,
    ArRobot::getRealBatteryVoltage). What no 12 V battery has is real whatever the firmware.
    """
    real = sip.tail.battery_decivolts
    if real is not None:
        return 0.1 * real
    volts = 0.1 * sip.battery_decivolts
    return volts * model.battery_share if volts < _MOST_OF_12 else volts


def _charge_state(code: int | None) -> ChargeState | None:
    if code is None:
        return None
    return ChargeState(code) if code in _CHARGE_CODES else ChargeState.UNKNOWN


def _turn_rate(decidegrees: int | None) -> float | None:
    return None if decidegrees is None else math.radians(0.1 * decidegrees)


def _temperature(celsius: int | None) -> int | None:
    return None if celsius is None or celsius <= NO_TEMPERATURE else celsius
