from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.p2os.command_numbers import ARGUMENT_RANGES, CommandNumber
from drivers.p2os.commands import (
    CLOSE,
    E_STOP,
    OPEN,
    REQUEST_CONFIG,
    STOP,
    SYNCS,
    Command,
    CommandRangeError,
    command,
    decode_command,
    host_baud,
)

N = CommandNumber
ENCODED = [
    (SYNCS[0], "FA FB 03 00 00 00"),
    (SYNCS[1], "FA FB 03 01 00 01"),
    (SYNCS[2], "FA FB 03 02 00 02"),
    (OPEN, "FA FB 06 01 3B 01 00 02 3B"),
    (CLOSE, "FA FB 06 02 3B 01 00 03 3B"),
    (command(N.ENABLE, 1), "FA FB 06 04 3B 01 00 05 3B"),
    (command(N.ENABLE, 0), "FA FB 06 04 3B 00 00 04 3B"),
    (command(N.SETA, 300), "FA FB 06 05 3B 2C 01 31 3C"),
    (command(N.SETA, -300), "FA FB 06 05 1B 2C 01 31 1C"),
    (command(N.SETV, 400), "FA FB 06 06 3B 90 01 96 3C"),
    (command(N.SETO), "FA FB 03 07 00 07"),
    (command(N.VEL, 300), "FA FB 06 0B 3B 2C 01 37 3C"),
    (command(N.VEL, -300), "FA FB 06 0B 1B 2C 01 37 1C"),
    (command(N.HEAD, 90), "FA FB 06 0C 3B 5A 00 66 3B"),
    (Command(15, bytes((1, 6, 2, 105))), "FA FB 09 0F 2B 04 01 06 02 69 19 47"),
    (REQUEST_CONFIG, "FA FB 06 12 3B 01 00 13 3B"),
    (Command(19, 2), "FA FB 06 13 3B 02 00 15 3B"),
    (command(N.RVEL, 20), "FA FB 06 15 3B 14 00 29 3B"),
    (command(N.RVEL, -20), "FA FB 06 15 1B 14 00 29 1B"),
    (command(N.SETRA, 100), "FA FB 06 17 3B 64 00 7B 3B"),
    (command(N.SONAR, 0), "FA FB 06 1C 3B 00 00 1C 3B"),
    (command(N.SONAR, 1), "FA FB 06 1C 3B 01 00 1D 3B"),
    (STOP, "FA FB 03 1D 00 1D"),
    (Command(30, -0x0919), "FA FB 06 1E 1B 19 09 37 24"),
    (Command(N.VEL2, 0x0A0A), "FA FB 06 20 3B 0A 0A 2A 45"),
    (Command(N.VEL2, 0xFB05), "FA FB 06 20 3B 05 FB 26 36"),
    (Command(40, 2), "FA FB 06 28 3B 02 00 2A 3B"),
    (command(N.BUMP_STALL, 3), "FA FB 06 2C 3B 03 00 2F 3B"),
    (host_baud(38400), "FA FB 06 32 3B 02 00 34 3B"),
    (E_STOP, "FA FB 03 37 00 37"),
    (Command(N.POLLING, bytes((1, 2, 1, 2))), "FA FB 09 03 2B 04 01 02 01 02 09 2F"),
    (Command(3, bytes((1, 2, 1, 2)), b"\0"), "FA FB 0A 03 2B 04 01 02 01 02 00 0B 2D"),
    (Command(32, -0x02FD), "fafb06201bfd021d1d"),
    (Command(15, b"\x01\x20", b"\0"), "fafb080f2b02012000312c"),
]


@pytest.mark.parametrize(("sent", "text"), ENCODED)
def test_documented_bytes_are_encoded_and_decoded(sent: Command, text: str) -> None:
    packet = bytes.fromhex(text)
    assert sent.encode() == packet
    assert decode_command(packet[3:-2]) == sent


@pytest.mark.parametrize("argument", ["20 3B 05 FB", "20 1B FB 04"])
def test_two_byte_argument_by_either_sign_convention(argument: str) -> None:
    assert decode_command(bytes.fromhex(argument)).two_bytes == (-5, 5)


def test_argument_type_without_argument_is_surplus() -> None:
    assert decode_command(bytes((7, 0x3B))) == Command(7, None, b"\x3b")
    assert decode_command(bytes((15, 0x2B, 9, 1))) == Command(15, None, b"\x2b\x09\x01")


@pytest.mark.parametrize(("number", "allowed"), ARGUMENT_RANGES.items())
def test_ranges_are_closed(number: CommandNumber, allowed: tuple[int, int]) -> None:
    for bound in allowed:
        assert command(number, bound).argument == bound
    for outside in (allowed[0] - 1, allowed[1] + 1):
        with pytest.raises(CommandRangeError, match=number.name):
            command(number, outside)


def test_invalid_arguments_are_refused() -> None:
    with pytest.raises(CommandRangeError, match="STOP: takes no"):
        command(N.STOP, 1)
    with pytest.raises(CommandRangeError, match="VEL: needs"):
        command(N.VEL)
    with pytest.raises(CommandRangeError, match="HOSTBAUD"):
        host_baud(4800)


@given(
    st.integers(0, 255), st.one_of(st.none(), st.integers(-65535, 65535), st.binary(max_size=196))
)
def test_commands_round_trip(number: int, argument: int | bytes | None) -> None:
    sent = Command(number, argument)
    assert decode_command(sent.encode()[3:-2]) == sent


@given(st.binary(min_size=1, max_size=253))
def test_any_data_decodes_to_a_command(data: bytes) -> None:
    assert decode_command(data).number == data[0]
