"""P2OS commands, client to robot: checked building, encoding and decoding.

Source: Pioneer 2 Operations Manual, command tables. An integer argument goes as sign and
magnitude: type ``3B`` or, for a negative one, ``1B``, then the magnitude in 16 bits.
"""

from __future__ import annotations

from dataclasses import dataclass

from drivers.p2os.command_numbers import (
    ARGUMENT_RANGES,
    OPTIONAL_ARGUMENT,
    CommandNumber,
)
from drivers.p2os.framing import encode_packet

NON_NEGATIVE = 0x3B
NEGATIVE = 0x1B
STRING = 0x2B
HOST_BAUDS = (9600, 19200, 38400, 57600, 115200)
"""Rates in the order of HOSTBAUD's codes."""


class CommandRangeError(ValueError):
    """The argument is outside the command's range."""


@dataclass(frozen=True, slots=True)
class Command:
    """One command: number, argument, and any bytes behind the argument on the wire.

    ``surplus`` holds meaningless bytes that clients append: a string's uncounted NUL, an argument
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
        """The argument as a (high, low) pair of signed bytes, with either encoding of its sign."""
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
