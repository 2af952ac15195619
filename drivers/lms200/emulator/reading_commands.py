"""What an emulated LMS 200 tells of itself: status, errors, type, hours, configurations.

Source: SICK telegram listing 8007954/Q501, replies B1, B2, B5, BA, F4, FC; the status telegram's
fields as sicktoolbox reads them. The values of a healthy scanner's receiver are ours.
"""

from __future__ import annotations

import struct
from collections.abc import Callable

from drivers.lms200 import telegrams
from drivers.lms200.emulator.answer import Answer
from drivers.lms200.emulator.laser_state import POWER_ON_BAUD, LaserState
from drivers.lms200.emulator.measured_output import Content, MeasuredOutput
from drivers.lms200.emulator.mirror import TURN
from drivers.lms200.errors import encode_errors
from drivers.lms200.telegrams import Command, DeviceStatus, Mode

_HOURS = 1000  # of operation; ours
_MOTOR_PARTS = 90  # of a turn: the motor's time is that of one of them, us
_CLEAN, _POLLUTED = 100, 40  # a window channel's signal; ours
_STATUS_FIELDS = {  # place in the reply: layout
    18: "B",  # variant: 0 standard
    19: "<8H",  # the window's channels
    35: "<4H",  # the references of pollution
    43: "<8H",  # both as calibrated
    59: "<4H",
    67: "<H",  # time of a part of a turn
    71: "<H",  # receiver without signal: references 1 and 2 at 100 and 66 %
    75: "<H",
    77: "<H",
    81: "<H",
    83: "<H",  # laser power, % of the calibrated
    85: "<H",  # angle of that measurement
    87: "<H",  # peak threshold of that measurement
    89: "<H",  # angle of the reference target
    91: "<H",  # power as calibrated
    93: "<4H",  # stop and peak threshold: wanted, then present
    103: "<2H",  # values filtered at the reference target: single, means
    111: "B",  # restart mode
    112: "<H",  # restart time
    114: "B",  # second multiple evaluation
    118: "B",  # multiple evaluation
    120: "B",  # address
    121: "B",  # active field set
    123: "B",  # laser on
    124: "7s",  # boot PROM
}


def _status(state: LaserState, data: bytes) -> Answer | None:
    if data:
        return None
    payload = bytearray(
        DeviceStatus(
            software=state.software,
            mode=state.mode,
            defective=state.health.defective,
            measuring_mode=state.configuration.measuring_mode,
            variant=state.variant,
            baud=state.baud,
            units=state.configuration.units,
            permanent_baud=state.permanent_baud != POWER_ON_BAUD,
        ).encode()
    )
    for place, values in _status_values(state).items():
        struct.pack_into(_STATUS_FIELDS[place], payload, place, *values)
    return Answer(bytes(payload[:-1]))


def _status_values(state: LaserState) -> dict[int, tuple[int | bytes, ...]]:
    """Return the values of _STATUS_FIELDS."""
    window = _POLLUTED if state.health.pollution else _CLEAN
    block = state.configuration.block
    threshold = block[2]
    return {
        18: (0,),
        19: (window,) * 8,
        35: (_CLEAN,) * 4,
        43: (_CLEAN,) * 8,
        59: (_CLEAN,) * 4,
        67: (round(TURN * 1e6 / _MOTOR_PARTS),),
        71: (10,),
        75: (10,),
        77: (7,),
        81: (7,),
        83: (100,),
        85: (90,),
        87: (threshold,),
        89: (270,),
        91: (100,),
        93: (threshold,) * 4,
        103: (0, 0),
        111: (block[10],),
        112: (_octet(block, 11),),
        114: (_octet(block, 12),),
        118: (state.configuration.evaluations,),
        120: (state.address,),
        121: (state.fields.active_set,),
        123: (1,),
        124: (state.software.encode("ascii", "replace")[:7].ljust(7),),
    }


def _octet(block: bytes, place: int) -> int:
    return block[place] if place < len(block) else 0


def _errors(state: LaserState, data: bytes) -> Answer | None:
    return None if data else Answer(encode_errors(state.health.errors)[:-1])


def _hours(_state: LaserState, data: bytes) -> Answer | None:
    return None if data else Answer(struct.pack("<BI", Command.OPERATING_HOURS.reply, _HOURS))


def _type(state: LaserState, data: bytes) -> Answer | None:
    if data:
        return None
    return Answer(telegrams.encode_text(Command.TYPE.reply, state.type)[:-1])


def _configuration(state: LaserState, data: bytes) -> Answer | None:
    head = bytes((Command.READ_CONFIGURATION.reply,))
    return None if data else Answer(head + state.configuration.block)


def _extended(state: LaserState, data: bytes) -> Answer | None:
    head = bytes((Command.READ_EXTENDED.reply,))
    return None if data else Answer(head + state.extended)


def _positioning_aid(state: LaserState, data: bytes) -> Answer | None:
    """Return where reflectors are, of one scan."""
    if data:
        return None
    part = state.positioning_range or (1, state.variant.count)
    first, last = part if part[1] <= state.variant.count else (1, state.variant.count)
    reply = Command.POSITIONING_AID.reply
    output = MeasuredOutput(reply, Content.POSITIONING, parts=((first, last),))
    return Answer(enter=Mode.ON_REQUEST, output=output)


READING_COMMANDS: dict[int, Callable[[LaserState, bytes], Answer | None]] = {
    Command.STATUS: _status,
    Command.ERRORS: _errors,
    Command.OPERATING_HOURS: _hours,
    Command.TYPE: _type,
    Command.READ_CONFIGURATION: _configuration,
    Command.READ_EXTENDED: _extended,
    Command.POSITIONING_AID: _positioning_aid,
}
