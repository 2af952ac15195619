"""Commands and replies of the LMS 200."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.lms200 import telegrams
from drivers.lms200.errors import decode_errors
from drivers.lms200.framing import Telegram, encode_telegram
from drivers.lms200.telegrams import (
    STANDARD_CONFIGURATION,
    VARIANTS,
    Configuration,
    DeviceStatus,
    Variant,
    VariantReply,
)


def reply(payload: bytes) -> Telegram:
    return Telegram(0x80, payload)


@pytest.mark.parametrize(
    ("command", "frame"),
    [
        (telegrams.SELECT_INSTALLATION, "02 00 0A 00 20 00 53 49 43 4B 5F 4C 4D 53 BE C5"),
        (telegrams.SELECT_CONTINUOUS, "02 00 02 00 20 24 34 08"),
        (telegrams.SELECT_ON_REQUEST, "02 00 02 00 20 25 35 08"),
        (telegrams.select_baud(38400), "02 00 02 00 20 40 50 08"),
        (telegrams.select_baud(19200), "02 00 02 00 20 41 51 08"),
        (telegrams.select_baud(9600), "02 00 02 00 20 42 52 08"),
        (telegrams.select_baud(500000), "02 00 02 00 20 48 58 08"),
        (telegrams.READ_TYPE, "02 00 01 00 3A 1E 12"),
        (telegrams.READ_STATUS, "02 00 01 00 31 15 12"),
        (telegrams.READ_ERRORS, "02 00 01 00 32 16 12"),
        (telegrams.READ_CONFIGURATION, "02 00 01 00 74 50 12"),
        (telegrams.set_variant(Variant(180, 50)), "02 00 05 00 3B B4 00 32 00 3B 1F"),
        (
            telegrams.write_configuration(STANDARD_CONFIGURATION),
            "02 00 23 00 77 00 00 46 00 00 00 01 00 00 02 02 02 00 00 0A 0A 50 64 00 0A 0A 50 80"
            " 00 0A 0A 50 64 00 00 00 00 02 00 7B 4B",
        ),
    ],
)
def test_commands_are_the_documented_frames(command: bytes, frame: str) -> None:
    assert encode_telegram(command) == bytes.fromhex(frame)


def test_variants_give_the_documented_counts_and_turns() -> None:
    assert [(v.count, v.mirror_turns) for v in VARIANTS] == [
        (181, 1),
        (361, 2),
        (101, 1),
        (201, 2),
        (401, 4),
    ]


def test_variant_reply_matches_the_example() -> None:
    payload = bytes.fromhex("BB 01 B4 00 32 00 10")
    decoded = VariantReply.decode(reply(payload))
    assert decoded == VariantReply(accepted=True, variant=Variant(180, 50))
    assert decoded.encode() == payload
    assert VariantReply.decode(reply(payload[:5])) is None


def test_status_fields_are_at_the_documented_offsets() -> None:
    payload = bytearray(154)
    payload[0] = 0xB1
    payload[1:8] = b"V02.10 "
    payload[8] = 0x25
    payload[102] = 5
    payload[107:111] = bytes.fromhex("B4 00 64 00")
    payload[116:118] = bytes.fromhex("19 80")
    payload[122] = 1
    payload[-1] = 0x10
    status = DeviceStatus("V02.10", 0x25, False, 5, Variant(180, 100), 38400, 1)
    assert DeviceStatus.decode(reply(bytes(payload))) == status
    assert status.encode() == bytes(payload)
    assert len(encode_telegram(status.encode(), 0x80)) == 160
    assert DeviceStatus.decode(reply(bytes(payload[:123]))) is None
    assert DeviceStatus.decode(reply(bytes(payload[:124]))) == status


def test_only_measuring_mode_and_units_of_a_configuration_change() -> None:
    changed = STANDARD_CONFIGURATION.changed(measuring_mode=5, units=0)
    differing = [
        at
        for at, (old, new) in enumerate(
            zip(STANDARD_CONFIGURATION.block, changed.block, strict=True)
        )
        if old != new
    ]
    assert differing == [5, 6]
    assert (changed.measuring_mode, changed.units) == (5, 0)


def test_short_configuration_replaces_the_beginning() -> None:
    whole = STANDARD_CONFIGURATION.overlaid(bytes.fromhex("00 00 70 01 00 06 00"))
    assert len(whole.block) == 34
    assert whole.block[:8] == bytes.fromhex("00 00 70 01 00 06 00 00")
    assert whole.block[8:] == STANDARD_CONFIGURATION.block[8:]


def test_configuration_of_invalid_length_is_none() -> None:
    assert Configuration.decode(bytes(6)) is None
    assert Configuration.decode(bytes(7)) is not None
    assert Configuration.decode(bytes(200)) is None


def test_power_on_telegram_has_its_text() -> None:
    payload = telegrams.encode_text(telegrams.POWER_ON, "LMS200;301063;V02.10 ")
    assert telegrams.decode_text(reply(payload)) == "LMS200;301063;V02.10"


@given(st.binary(min_size=1, max_size=200))
def test_arbitrary_replies_do_not_raise(payload: bytes) -> None:
    telegram = reply(payload)
    telegrams.decode_text(telegram)
    decode_errors(telegram)
    telegrams.first_data_byte(telegram)
    telegrams.decode_read_configuration(telegram)
    VariantReply.decode(telegram)
    DeviceStatus.decode(telegram)
