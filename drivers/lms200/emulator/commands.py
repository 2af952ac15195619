"""The commands of an emulated LMS 200, by group: reading, settings, fields, measured values, modes.

Source: SICK telegram listing 8007954/Q501; ``listing.toml`` beside the tests has each command with
its reply and where the layout is known from.
"""

from __future__ import annotations

from collections.abc import Callable

from drivers.lms200.emulator.answer import Answer
from drivers.lms200.emulator.field_commands import FIELD_COMMANDS
from drivers.lms200.emulator.laser_state import LaserState
from drivers.lms200.emulator.measured_output import requested
from drivers.lms200.emulator.mode_command import select_mode
from drivers.lms200.emulator.reading_commands import READING_COMMANDS
from drivers.lms200.emulator.setting_commands import SETTING_COMMANDS
from drivers.lms200.telegrams import RESET_CONFIRMED, Command, Mode

Handler = Callable[[LaserState, bytes], Answer | None]


def answer_to(payload: bytes, state: LaserState) -> Answer | None:
    """Return the answer to command and data; None for 92, not a command or not allowed now."""
    command, data = payload[0], payload[1:]
    handler = _HANDLERS.get(command)
    if handler is not None:
        return handler(state, data)
    output = requested(command, data, state.variant)
    return None if output is None else Answer(enter=Mode.ON_REQUEST, output=output)


def _reset(state: LaserState, data: bytes) -> Answer | None:
    if data:
        return None
    reply = bytes((RESET_CONFIRMED,))
    return Answer(reply, baud_after=state.permanent_baud, restarts=True)


_HANDLERS: dict[int, Handler] = {
    Command.RESET: _reset,
    Command.MODE: select_mode,
    **READING_COMMANDS,
    **SETTING_COMMANDS,
    **FIELD_COMMANDS,
}
