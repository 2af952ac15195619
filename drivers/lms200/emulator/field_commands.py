"""The monitored fields of an emulated LMS 200: written, read, taught, switched.

Source: SICK telegram listing 8007954/Q501, commands 40, 41, 45, 46, 4A; their layouts are ours.
"""

from __future__ import annotations

from collections.abc import Callable

from drivers.lms200.emulator.answer import EEPROM_WRITE, MODE_CHANGE, Answer
from drivers.lms200.emulator.fields import FIELD_NUMBERS, FIELD_SETS
from drivers.lms200.emulator.laser_state import LaserState
from drivers.lms200.emulator.measured_output import Content, MeasuredOutput
from drivers.lms200.telegrams import Command, Mode


def _write_field(state: LaserState, data: bytes) -> Answer | None:
    if state.mode is not Mode.INSTALLATION or not data:
        return None
    accepted = state.fields.write(data[0], data[1:])
    reply = bytes((Command.WRITE_FIELD.reply, int(accepted)))
    return Answer(reply, takes=EEPROM_WRITE if accepted else 0.0)


def _read_field(state: LaserState, data: bytes) -> Answer | None:
    content = state.fields.read(data[0]) if len(data) == 1 else None
    if content is None:
        return None
    return Answer(bytes((Command.READ_FIELD.reply, data[0])) + content)


def _switch_set(state: LaserState, data: bytes) -> Answer | None:
    if len(data) != 1:
        return None
    accepted = data[0] in FIELD_SETS
    if accepted:
        state.fields.active_set = data[0]
    return Answer(bytes((Command.FIELD_SET.reply, int(accepted))), takes=MODE_CHANGE)


def _teach(state: LaserState, data: bytes) -> Answer | None:
    if state.mode is not Mode.INSTALLATION or len(data) != 1 or data[0] not in FIELD_NUMBERS:
        return None
    output = MeasuredOutput(Command.TEACH_FIELD.reply, Content.TEACHING, field=data[0])
    return Answer(output=output)


def _outputs(state: LaserState, data: bytes) -> Answer | None:
    """Return whether fields A, B and C are infringed, over as many scans as are evaluated."""
    if data:
        return None
    scans = max(state.configuration.evaluations, 1)
    output = MeasuredOutput(Command.FIELD_OUTPUTS.reply, Content.FIELD_OUTPUTS, scans)
    return Answer(enter=Mode.ON_REQUEST, output=output)


FIELD_COMMANDS: dict[int, Callable[[LaserState, bytes], Answer | None]] = {
    Command.WRITE_FIELD: _write_field,
    Command.FIELD_SET: _switch_set,
    Command.READ_FIELD: _read_field,
    Command.TEACH_FIELD: _teach,
    Command.FIELD_OUTPUTS: _outputs,
}
