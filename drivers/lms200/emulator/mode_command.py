"""The operating modes of an emulated LMS 200: command 20.

Source: SICK telegram listing 8007954/Q501, operating modes, passwords and transmission rates.
"""

from __future__ import annotations

from drivers.lms200 import telegrams
from drivers.lms200.emulator.answer import MODE_CHANGE, Answer
from drivers.lms200.emulator.laser_state import LaserState
from drivers.lms200.emulator.measured_output import is_stream, streamed
from drivers.lms200.telegrams import BAUD_MODES, Command, Mode

_BAUD_BY_MODE = {mode: baud for baud, mode in BAUD_MODES.items()}


def select_mode(state: LaserState, data: bytes) -> Answer | None:
    """Answer command 20: a mode, its parameters or password."""
    if not data:
        return None
    code, parameters = data[0], data[1:]
    if code in _BAUD_BY_MODE:
        return None if parameters else _selected(baud_after=_BAUD_BY_MODE[code])
    if code in (Mode.INSTALLATION, Mode.TEST_PASSWORD):
        if parameters != state.password:
            return _answer(telegrams.WRONG_PASSWORD)
        return _selected(enter=Mode.INSTALLATION if code == Mode.INSTALLATION else None)
    if code in (Mode.DIAGNOSTIC, Mode.ON_REQUEST):
        return None if parameters else _selected(enter=Mode(code))
    if not is_stream(code):
        return None
    mode = Mode(code)
    output = streamed(mode, parameters, state.variant)
    if output is None:
        return None
    if state.health.defective:
        return _answer(telegrams.MODE_FAULT)
    reply = bytes((Command.MODE.reply, telegrams.MODE_SELECTED))
    return Answer(reply, takes=MODE_CHANGE, enter=mode, output=output)


def _selected(enter: Mode | None = None, baud_after: int | None = None) -> Answer:
    reply = bytes((Command.MODE.reply, telegrams.MODE_SELECTED))
    return Answer(reply, takes=MODE_CHANGE, enter=enter, baud_after=baud_after)


def _answer(result: int) -> Answer:
    return Answer(bytes((Command.MODE.reply, result)))
