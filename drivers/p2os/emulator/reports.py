"""The report packets of an emulated controller."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from drivers.p2os.emulator.base import EmulatedBase
from drivers.p2os.extended_packets import EncoderPacket, IoPacket
from drivers.p2os.sip import (
    MOTORS_FLAG,
    POSITION_MASK,
    SIP_MOVING,
    SIP_STOPPED,
    STOP_BUTTON_FLAG,
    Sip,
    SipTail,
)

SONAR_FLAG = 0x0002
ANALOG_INPUTS = 5
BATTERY_FULL_SCALE = 20.0  # V, of the analog input that measures it
ANALOG_MAX = 1023


@dataclass(slots=True)
class EmulatedPins:
    """The user's digital outputs and inputs, and the analog input selected for the SIP."""

    analog_port: int = 5
    inputs: int = 0xFF
    outputs: int = 0x00

    def set_outputs(self, mask: int, states: int) -> None:
        """Set the outputs in ``mask`` to the bits of ``states``."""
        self.outputs = (self.outputs & ~mask | states & mask) & 0xFF


def sip_report(
    base: EmulatedBase,
    pins: EmulatedPins,
    sonar: Sequence[tuple[int, float]] | None,
    *,
    later_firmware: bool,
) -> Sip:
    """Return a SIP; ``sonar`` holds new (number, range m) readings, None when it is off.

    The battery is on the scale of a 12 V one (ARIA, ArRobot). Later firmware adds its real voltage,
    charge state, turn rate, faults and a flag for the stop button.
    """
    make = base.model
    v, w = base.velocity
    wheel_difference = w / make.turn
    stall = base.stalled
    flags = MOTORS_FLAG * base.motors_enabled | SONAR_FLAG * (sonar is not None)
    tail = SipTail(pins.analog_port, 0, 0, pins.inputs, pins.outputs)
    sip = Sip(
        packet_type=SIP_MOVING if abs(v) > 1e-3 or abs(w) > 1e-3 else SIP_STOPPED,
        x_counts=round(base.x / make.distance_count) & POSITION_MASK,
        y_counts=round(base.y / make.distance_count) & POSITION_MASK,
        heading_counts=_heading_counts(base.theta, make.heading_counts),
        left_speed_counts=round((v - wheel_difference) / make.speed_count),
        right_speed_counts=round((v + wheel_difference) / make.speed_count),
        battery_decivolts=min(round(10.0 * base.battery.reported_volts_of_12), 0xFF),
        left_stall_byte=stall | (base.rear_bumpers & 0x7F) << 1,
        right_stall_byte=stall | (base.front_bumpers & 0x7F) << 1,
        control_counts=_heading_counts(
            base.controller.heading_setpoint(base.heading), make.heading_counts
        ),
        flags=flags,
        compass_2deg=0,
        sonar=tuple((number, _sonar_counts(distance, base)) for number, distance in sonar or ()),
        tail=tail,
    )
    if not later_firmware:
        return sip
    tail = tail._replace(
        battery_decivolts=round(10.0 * base.battery.reported_volts),
        charge_state=base.battery.charge_state,
        turn_rate_decidegrees_s=round(math.degrees(10.0 * w)),
        fault_flags=0,
    )
    return replace(sip, flags=flags | STOP_BUTTON_FLAG * base.stop_button_pressed, tail=tail)


def encoder_report(base: EmulatedBase) -> EncoderPacket:
    """Return the encoders' counts."""
    return EncoderPacket(*base.ticks)


def io_report(base: EmulatedBase, pins: EmulatedPins) -> IoPacket:
    """Return the digital and analog pins; a pressed bumper segment's bit is 0."""
    bumpers = (~(mask << 1) & 0xFF for mask in (base.front_bumpers, base.rear_bumpers))
    inputs = bytes((pins.inputs, *bumpers, 0))
    battery = min(ANALOG_MAX, round(base.battery.reported_volts / BATTERY_FULL_SCALE * ANALOG_MAX))
    analog = (0,) * (ANALOG_INPUTS - 1) + (battery,)
    return IoPacket(inputs, bytes((pins.outputs,)), analog)


def _sonar_counts(distance: float, base: EmulatedBase) -> int:
    return round(min(distance, base.model.sonar_far) / base.model.range_count)


def _heading_counts(heading: float, per_turn: int) -> int:
    """Return a heading in rad as counts of at most half a turn, e.g. from -2048 to 2047."""
    counts = round(math.remainder(heading, math.tau) / math.tau * per_turn)
    half = per_turn // 2
    return (counts + half) % per_turn - half
