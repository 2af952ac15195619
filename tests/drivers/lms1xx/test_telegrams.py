"""Commands and replies as the listing and the recordings have them, in both dialects."""

from __future__ import annotations

import pytest

from drivers.lms1xx import telegrams
from drivers.lms1xx.fields import FieldWriter
from drivers.lms1xx.framing import Dialect, Telegram
from drivers.lms1xx.telegrams import Fault, OutputRange, ScanContent, Scanning


def test_login_is_as_the_listing_has_it() -> None:
    assert telegrams.login(Dialect.A) == b"sMN SetAccessMode 03 F4724744"
    assert telegrams.login(Dialect.B) == b"sMN SetAccessMode \x03\xf4\x72\x47\x44"


def test_scanning_is_read_in_both_forms() -> None:
    read = Telegram(Dialect.A, b"sRA LMPscancfg 1388 1 1388 FFF92230 225510")
    ordered = Telegram(Dialect.A, b"sMN mLMPsetscancfg +5000 +1 +5000 -450000 +2250000")
    expected = Scanning(5000, 5000, -450000, 2250000)
    assert Scanning.decode(read) == Scanning.decode(ordered) == expected
    reply = Telegram(Dialect.A, b"sAN mLMPsetscancfg 0 1388 1 1388 FFF92230 225510")
    assert Scanning.decode_set(reply) == (0, expected)


def test_content_is_as_recorded_from_an_lms_111() -> None:
    recorded = bytes.fromhex("01000000000000000000010001")
    telegram = Telegram(Dialect.B, b"sRA LMDscandatacfg " + recorded)
    content = ScanContent.decode(telegram)
    assert content == ScanContent(time=True)
    assert content is not None
    writer = FieldWriter("sRA LMDscandatacfg", Dialect.B)
    assert content.write(writer).payload == telegram.payload


def test_content_is_as_clients_write_it() -> None:
    telegram = Telegram(Dialect.A, b"sWN LMDscandatacfg 03 00 1 1 0 01 00 1 0 0 1 +2")
    expected = ScanContent(
        echoes=3, remission=True, wide=True, encoder=1, position=True, time=True, every=2
    )
    assert ScanContent.decode(telegram) == expected


@pytest.mark.parametrize("dialect", Dialect)
@pytest.mark.parametrize(
    "settings",
    [
        Scanning(2500, 2500, -450000, 2250000),
        OutputRange(1667, -50000, 1850000),
        ScanContent(echoes=3, remission=True, wide=True, name=True, comment=True, every=7),
    ],
)
def test_settings_come_back(
    dialect: Dialect, settings: Scanning | OutputRange | ScanContent
) -> None:
    payload = settings.write(FieldWriter("sRA x", dialect)).payload
    assert type(settings).decode(Telegram(dialect, payload)) == settings
    cut = Telegram(dialect, payload[:-8])
    assert type(settings).decode(cut) is None


@pytest.mark.parametrize(
    ("dialect", "payload", "fault"),
    [
        (Dialect.B, b"sFA\x00\x0a", Fault.WRITE_DENIED),  # of a TiM, as its owner published
        (Dialect.A, b"sFA A", Fault.WRITE_DENIED),
        (Dialect.B, b"sFA \x00\x03", Fault.UNKNOWN_VARIABLE),
        (Dialect.A, b"sFA", 0),
        (Dialect.A, b"sRA x 1", None),
    ],
)
def test_error_replies_are_told_from_others(
    dialect: Dialect, payload: bytes, fault: int | None
) -> None:
    assert telegrams.decode_fault(Telegram(dialect, payload)) == fault


@pytest.mark.parametrize("dialect", Dialect)
def test_error_replies_come_back(dialect: Dialect) -> None:
    payload = telegrams.encode_fault(Fault.ACCESS_DENIED, dialect)
    assert telegrams.decode_fault(Telegram(dialect, payload)) == Fault.ACCESS_DENIED


def test_identity_may_hold_spaces() -> None:
    identity = Telegram(Dialect.A, b"sRA DeviceIdent 8 LMS 111  9 V1.80.2  ")
    assert telegrams.decode_identity(identity) == "LMS 111 V1.80.2"
    assert telegrams.decode_identity(Telegram(Dialect.A, b"sRA DeviceIdent 20 LMS")) is None


def test_replies_have_their_commands_names() -> None:
    assert telegrams.reply_to(telegrams.SET_SCANNING) == "sAN mLMPsetscancfg"
    assert telegrams.reply_to(telegrams.STREAM) == "sEA LMDscandata"
    assert telegrams.reply_to("nonsense") == ""
