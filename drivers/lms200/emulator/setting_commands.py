"""The settings of an emulated LMS 200: variant, configurations, password, permanent rate.

Source: SICK telegram listing 8007954/Q501, commands 3B, 42, 66, 6A, 77, 7B.
"""

from __future__ import annotations

import struct
from collections.abc import Callable

from drivers.lms200 import telegrams
from drivers.lms200.emulator.answer import EEPROM_WRITE, MODE_CHANGE, Answer
from drivers.lms200.emulator.laser_state import POWER_ON_BAUD, LaserState
from drivers.lms200.emulator.measured_output import is_stream
from drivers.lms200.emulator.value_telegrams import MODE_REFLECTIVITY_ONLY
from drivers.lms200.measurement import MEASURING_MODES, UNIT_CM, UNIT_MM
from drivers.lms200.telegrams import Command, Configuration, Mode, Variant, VariantReply

_ONE_DEGREE = 100  # the resolution that a request for 0 means to the client that sends it
_RATE_TO_9600, _RATE_KEPT, _RATE_ASKED = b"\x00", b"\x01", b"\x02"
_MEASURING_MODES = {*MEASURING_MODES, MODE_REFLECTIVITY_ONLY}


def _set_variant(state: LaserState, data: bytes) -> Answer | None:
    if len(data) != 4:
        return None
    angle, resolution = struct.unpack("<HH", data)
    wanted = Variant(angle, resolution or _ONE_DEGREE)
    accepted = wanted in telegrams.VARIANTS
    if accepted:
        state.variant = wanted
        state.variant_writes += 1
    reply = VariantReply(accepted, state.variant).encode()[:-1]
    # What is being measured ends: a stream, or a request.
    enter = Mode.ON_REQUEST if is_stream(state.mode) else state.mode
    return Answer(reply, takes=EEPROM_WRITE if accepted else 0.0, enter=enter)


def _write_configuration(state: LaserState, block: bytes) -> Answer | None:
    """Set the configuration; a block shorter than the present one replaces its beginning."""
    if state.mode is not Mode.INSTALLATION:
        return None
    fits = Configuration.SHORTEST <= len(block) <= len(state.configuration.block)
    wanted = state.configuration.overlaid(block) if fits else state.configuration
    usable = wanted.measuring_mode in _MEASURING_MODES and wanted.units in (UNIT_CM, UNIT_MM)
    accepted = fits and usable
    if accepted:
        state.configuration = wanted
        state.configuration_writes += 1
    return _written(Command.WRITE_CONFIGURATION, block, accepted=accepted)


def _write_extended(state: LaserState, block: bytes) -> Answer | None:
    if state.mode is not Mode.INSTALLATION:
        return None
    accepted = 0 < len(block) <= len(state.extended)
    if accepted:
        state.extended = block + state.extended[len(block) :]
    return _written(Command.WRITE_EXTENDED, block, accepted=accepted)


def _written(command: Command, block: bytes, *, accepted: bool) -> Answer:
    reply = bytes((command.reply, int(accepted))) + block[: Configuration.LONGEST]
    return Answer(reply, takes=EEPROM_WRITE if accepted else 0.0)


def _set_password(state: LaserState, data: bytes) -> Answer | None:
    """Set the password of the installation mode: its last 8 characters."""
    if state.mode is not Mode.INSTALLATION or len(data) not in (8, 9):
        return None
    state.password = data[-8:]
    return Answer(bytes((Command.PASSWORD.reply, telegrams.ACCEPTED)), takes=EEPROM_WRITE)


def _set_permanent_baud(state: LaserState, data: bytes) -> Answer | None:
    """Power on at the present rate from now on, or at 9600; or tell which."""
    reply = Command.PERMANENT_BAUD.reply
    if data == _RATE_ASKED:
        return Answer(bytes((reply, int(state.permanent_baud != POWER_ON_BAUD))))
    if data not in (_RATE_TO_9600, _RATE_KEPT):
        return None
    state.permanent_baud = state.baud if data == _RATE_KEPT else POWER_ON_BAUD
    return Answer(bytes((reply, telegrams.ACCEPTED)), takes=EEPROM_WRITE)


def _set_positioning_range(state: LaserState, data: bytes) -> Answer | None:
    if len(data) != 4:
        return None
    first, last = struct.unpack("<HH", data)
    accepted = 1 <= first <= last <= state.variant.count
    if accepted:
        state.positioning_range = (first, last)
    return Answer(bytes((Command.POSITIONING_RANGE.reply, int(accepted))), takes=MODE_CHANGE)


SETTING_COMMANDS: dict[int, Callable[[LaserState, bytes], Answer | None]] = {
    Command.VARIANT: _set_variant,
    Command.PASSWORD: _set_password,
    Command.PERMANENT_BAUD: _set_permanent_baud,
    Command.POSITIONING_RANGE: _set_positioning_range,
    Command.WRITE_CONFIGURATION: _write_configuration,
    Command.WRITE_EXTENDED: _write_extended,
}
