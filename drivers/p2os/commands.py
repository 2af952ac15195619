"""P2OS commands, client to robot: checked building, encoding and decoding.

Source: Pioneer 2 Operations Manual, command tables. An integer argument goes as sign and
magnitude: type ``3B`` or, for a negative one, ``1B``, then the magnitude in 16 bits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from drivers.p2os.command_numbers import (
    ARGUMENT_RANGES,
    OPTIONAL_ARGUMENT,
    TEXT_LENGTHS,
    CommandNumber,
)
from drivers.p2os.framing import encode_packet

NON_NEGATIVE = 0x3B
NEGATIVE = 0x1B
STRING = 0x2B
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
    """Build a command with a string argument; raises CommandRangeError if it takes none so long."""
    longest = TEXT_LENGTHS.get(number)
    if longest is None:
        raise CommandRangeError(f"{number.name}: takes no string")
    if len(text) > longest:
        raise CommandRangeError(f"{number.name}: {len(text)} bytes, at most {longest} fit")
    return Command(number, text)


def sonar_order(transducers: Sequence[int]) -> Command:
    """Build POLLING from transducer numbers, 0 to 31, in firing order; none silences them all.

    Raises CommandRangeError, also for more than 16 of one ring of 8.
    """
    if not all(0 <= number < 32 for number in transducers):
        raise CommandRangeError(f"POLLING: {list(transducers)} are not all in (0, 31)")
    rings = [number // 8 for number in transducers]
    if any(rings.count(ring) > 16 for ring in set(rings)):
        raise CommandRangeError("POLLING: at most 16 entries of one ring fit")
    return text_command(CommandNumber.POLLING, bytes(number + 1 for number in transducers))


def say(sounds: Sequence[tuple[int, int]]) -> Command:
    """Build SAY from up to 20 pairs (duration in 20 ms, tone code), 0 to 255 each; raises
    CommandRangeError."""
    flat = [value for sound in sounds for value in sound]
    if not all(0 <= value <= 255 for value in flat):
        raise CommandRangeError(f"SAY: {flat} are not all in (0, 255)")
    return text_command(CommandNumber.SAY, bytes(flat))


def wheel_speeds(left: int, right: int) -> Command:
    """Build VEL2 from wheel speeds in counts of 20 mm/s, -126 to 126; raises CommandRangeError."""
    if not (-126 <= left <= 126 and -126 <= right <= 126):
        raise CommandRangeError(f"VEL2: wheel counts ({left}, {right}) are outside (-126, 126)")
    return Command(CommandNumber.VEL2, (left & 0xFF) << 8 | right & 0xFF)


def digital_outputs(mask: int, states: int) -> Command:
    """Build DIGOUT: set the outputs in ``mask`` to the bits of ``states``; raises
    CommandRangeError."""
    if not (0 <= mask <= 255 and 0 <= states <= 255):
        raise CommandRangeError(f"DIGOUT: mask {mask}, states {states} are not in (0, 255)")
    return Command(CommandNumber.DIGOUT, mask << 8 | states)


def servo_pulse(port: int, pulse_10us: int) -> Command:
    """Build PTUPOS: pulse length, in 10 us, of the servo at a port, 1 to 4; raises
    CommandRangeError."""
    if not (1 <= port <= 4 and 0 <= pulse_10us <= 255):
        raise CommandRangeError(f"PTUPOS: no pulse of {pulse_10us} x 10 us at port {port}")
    return Command(CommandNumber.PTUPOS, port << 8 | pulse_10us)


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
