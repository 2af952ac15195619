"""The report packets of an emulated controller."""

from __future__ import annotations

import math
from collections.abc import Sequence

from drivers.p2os.emulator.base import EmulatedBase
from drivers.p2os.emulator.board import EmulatedBoard
from drivers.p2os.emulator.firmware import Firmware
from drivers.p2os.extended_packets import EncoderPacket, IoPacket
from drivers.p2os.sip import (
    CHARGER_POWER_FLAG,
    E_STALL_FLAG,
    FIRST_ARRAY_FLAG,
    MOTORS_FLAG,
    POSITION_MASK,
    SIP_MOVING,
    SIP_STOPPED,
    SONAR_FLAGS,
    STOP_BUTTON_FLAG,
    Sip,
    SipTail,
)

ANALOG_INPUTS = {Firmware.P2OS: 5, Firmware.AROS: 5, Firmware.ARCOS: 9}
BATTERY_INPUT = 4
BATTERY_FULL_SCALE = 20.0  # V, of the analog input that measures it
ANALOG_MAX = 1023


def sip_report(base: EmulatedBase, board: EmulatedBoard, sonar: Sequence[tuple[int, float]]) -> Sip:
    """Return a SIP by the board's firmware; ``sonar`` holds new (number, range m) readings.

    The battery is on the scale of a 12 V one (ARIA, ArRobot). Later firmware adds its real voltage,
    charge state, turn rate and faults.
    """
    make = base.model
    v, w = base.velocity
    wheel_difference = w / make.turn
    stall = base.stalled
    tail = SipTail(
        board.pins.analog_port,
        0,
        0,
        board.pins.inputs,
        board.pins.outputs,
        battery_decivolts=round(10.0 * base.battery.reported_volts),
        charge_state=base.battery.charge_state,
        turn_rate_decidegrees_s=round(math.degrees(10.0 * w)),
        fault_flags=base.fault_flags,
    )
    return Sip(
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
        flags=_flags(base, board),
        compass_2deg=0,
        sonar=tuple((number, _sonar_counts(distance, base)) for number, distance in sonar),
        tail=SipTail(*tail[: board.firmware.tail_fields]),
    )


def _flags(base: EmulatedBase, board: EmulatedBoard) -> int:
    firmware = board.firmware
    flags = MOTORS_FLAG * base.motors_enabled
    if firmware.has_sonar_arrays:
        flags |= sum(FIRST_ARRAY_FLAG << array for array in board.sonar.on) & SONAR_FLAGS
    else:
        flags |= FIRST_ARRAY_FLAG * board.sonar.is_on
    if firmware.reports_stop_button:
        flags |= STOP_BUTTON_FLAG * base.stop_button_pressed
        flags |= E_STALL_FLAG * base.stopped_by_button
        flags |= CHARGER_POWER_FLAG * base.battery.charging
    return flags


def encoder_report(base: EmulatedBase) -> EncoderPacket:
    """Return the encoders' counts."""
    return EncoderPacket(*base.ticks)


def io_report(base: EmulatedBase, board: EmulatedBoard) -> IoPacket:
    """Return the digital and analog pins; a pressed bumper segment's bit is 0."""
    bumpers = (~(mask << 1) & 0xFF for mask in (base.front_bumpers, base.rear_bumpers))
    pins = board.pins
    inputs = bytes((pins.inputs, *bumpers, 0))
    battery = min(ANALOG_MAX, round(base.battery.reported_volts / BATTERY_FULL_SCALE * ANALOG_MAX))
    analog = [0] * ANALOG_INPUTS[board.firmware]
    analog[BATTERY_INPUT] = battery
    return IoPacket(inputs, bytes((pins.outputs,)), tuple(analog))


def _sonar_counts(distance: float, base: EmulatedBase) -> int:
    return round(min(distance, base.model.sonar_far) / base.model.range_count)


def _heading_counts(heading: float, per_turn: int) -> int:
    """Return a heading in rad as counts of at most half a turn, e.g. from -2048 to 2047."""
    counts = round(math.remainder(heading, math.tau) / math.tau * per_turn)
    half = per_turn // 2
    return (counts + half) % per_turn - half
