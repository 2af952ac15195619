"""P2OS commands, client to robot: numbers, argument ranges, encoding and decoding.

Source: Pioneer 2 Operations Manual, command tables. An integer argument goes as sign and
magnitude: type ``3B`` or, for a negative one, ``1B``, then the magnitude in 16 bits.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from drivers.p2os.framing import encode_packet

NON_NEGATIVE = 0x3B
NEGATIVE = 0x1B
STRING = 0x2B
MAX_STRING = 196
MAX_MAGNITUDE = 0xFFFF


class CommandNumber(IntEnum):
    """Numbers of the commands that the session sends or the emulator obeys.

    0, 1, 2 are SYNC0, SYNC1, SYNC2 until the servers are open and PULSE, OPEN, CLOSE afterwards.
    """

    SYNC0 = 0
    SYNC1 = 1
    SYNC2 = 2
    PULSE = 0
    OPEN = 1
    CLOSE = 2
    POLLING = 3
    ENABLE = 4
    SETA = 5
    SETV = 6
    SETO = 7
    MOVE = 8
    SETRV = 10
    VEL = 11
    HEAD = 12
    DHEAD = 13
    CONFIG = 18
    RVEL = 21
    SETRA = 23
    SONAR = 28
    STOP = 29
    VEL2 = 32
    BUMP_STALL = 44
    HOSTBAUD = 50
    E_STOP = 55


ARGUMENT_RANGES: dict[CommandNumber, tuple[int, int]] = {
    CommandNumber.OPEN: (1, 1),
    CommandNumber.CLOSE: (1, 1),
    CommandNumber.ENABLE: (0, 1),
    CommandNumber.SETA: (-5000, 5000),  # mm/s^2; negative sets the deceleration
    CommandNumber.SETV: (0, 5000),  # mm/s
    CommandNumber.MOVE: (-5000, 5000),  # mm
    CommandNumber.SETRV: (0, 500),  # deg/s
    CommandNumber.VEL: (-2200, 2200),  # mm/s
    CommandNumber.HEAD: (-359, 359),  # deg, absolute
    CommandNumber.DHEAD: (-359, 359),  # deg, relative
    CommandNumber.CONFIG: (1, 1),
    CommandNumber.RVEL: (-500, 500),  # deg/s
    CommandNumber.SETRA: (-2000, 2000),  # deg/s^2; negative sets the deceleration
    CommandNumber.SONAR: (0, 1),
    CommandNumber.VEL2: (0, MAX_MAGNITUDE),  # left count * 256 + right count
    CommandNumber.BUMP_STALL: (0, 3),  # 0 off, 1 front, 2 rear, 3 both
    CommandNumber.HOSTBAUD: (0, 4),
}
"""Integer arguments a command may take; a number not listed takes none."""

OPTIONAL_ARGUMENT = frozenset((CommandNumber.OPEN, CommandNumber.CLOSE, CommandNumber.CONFIG))
HOST_BAUDS = (9600, 19200, 38400, 57600, 115200)
"""Rates in the order of HOSTBAUD's codes."""


class CommandRangeError(ValueError):
    """An argument that the command does not take."""


@dataclass(frozen=True, slots=True)
class Command:
    """One command: number, argument, and whatever bytes followed the argument on the wire.

    ``surplus`` holds what clients append without meaning: a string's uncounted NUL, an argument
    type without an argument.
    """

    number: int
    argument: int | bytes | None = None
    surplus: bytes = b""

    @property
    def integer(self) -> int:
        """The argument as an integer, 0 where there is none."""
        return self.argument if isinstance(self.argument, int) else 0

    @property
    def two_bytes(self) -> tuple[int, int]:
        """The argument as a (high, low) pair of signed bytes, however its sign was sent."""
        word = self.integer & 0xFFFF
        high, low = word >> 8, word & 0xFF
        return high - 256 * (high > 127), low - 256 * (low > 127)

    def encode(self) -> bytes:
        """Return the packet as it goes on the wire."""
        return encode_packet(bytes((self.number,)) + self._encode_argument() + self.surplus)

    def _encode_argument(self) -> bytes:
        argument = self.argument
        if argument is None:
            return b""
        if isinstance(argument, bytes):
            return bytes((STRING, len(argument))) + argument
        kind = NON_NEGATIVE if argument >= 0 else NEGATIVE
        return bytes((kind,)) + abs(argument).to_bytes(2, "little")


def command(number: CommandNumber, argument: int | None = None) -> Command:
    """Build a command, checked against ARGUMENT_RANGES; raises CommandRangeError."""
    allowed = ARGUMENT_RANGES.get(number)
    if argument is None:
        if allowed is not None and number not in OPTIONAL_ARGUMENT:
            raise CommandRangeError(f"{number.name}: needs an argument in {allowed}")
    elif allowed is None:
        raise CommandRangeError(f"{number.name}: takes no integer argument, got {argument}")
    elif not allowed[0] <= argument <= allowed[1]:
        raise CommandRangeError(f"{number.name}: {argument} is outside {allowed}")
    return Command(number, argument)


def text_command(number: CommandNumber, text: bytes) -> Command:
    """Build a command with a string argument (POLLING); raises CommandRangeError if too long."""
    if len(text) > MAX_STRING:
        raise CommandRangeError(f"{number.name}: {len(text)} bytes, at most {MAX_STRING} fit")
    return Command(number, text)


def wheel_speeds(left: int, right: int) -> Command:
    """Build VEL2 from wheel speeds in counts of 20 mm/s, -126 to 126; raises CommandRangeError."""
    if not (-126 <= left <= 126 and -126 <= right <= 126):
        raise CommandRangeError(f"VEL2: wheel counts ({left}, {right}) are outside (-126, 126)")
    return Command(CommandNumber.VEL2, (left & 0xFF) << 8 | right & 0xFF)


def host_baud(baud: int) -> Command:
    """Build HOSTBAUD from a rate in baud; raises CommandRangeError for one without a code."""
    if baud not in HOST_BAUDS:
        raise CommandRangeError(f"HOSTBAUD: {baud} is none of {HOST_BAUDS}")
    return Command(CommandNumber.HOSTBAUD, HOST_BAUDS.index(baud))


def decode_command(data: bytes) -> Command:
    """Read a command from a packet's data (at least one byte) as leniently as a controller does.

    Missing or truncated arguments become ``surplus``; nothing is range-checked.
    """
    number, rest = data[0], data[1:]
    if len(rest) >= 3 and rest[0] in (NON_NEGATIVE, NEGATIVE):
        magnitude = int.from_bytes(rest[1:3], "little")
        return Command(number, -magnitude if rest[0] == NEGATIVE else magnitude, rest[3:])
    if len(rest) >= 2 and rest[0] == STRING and len(rest) >= 2 + rest[1]:
        return Command(number, rest[2 : 2 + rest[1]], rest[2 + rest[1] :])
    return Command(number, None, rest)


SYNCS = (Command(0), Command(1), Command(2))
"""The three handshake commands, in order."""
PULSE = Command(CommandNumber.PULSE)
OPEN = Command(CommandNumber.OPEN, 1)
CLOSE = Command(CommandNumber.CLOSE, 1)
STOP = Command(CommandNumber.STOP)
E_STOP = Command(CommandNumber.E_STOP)
REQUEST_CONFIG = Command(CommandNumber.CONFIG, 1)
STAND_STILL = (Command(CommandNumber.VEL, 0), Command(CommandNumber.RVEL, 0))
"""Zero translation and zero rotation."""
