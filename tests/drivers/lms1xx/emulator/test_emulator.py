"""The emulated LMS 111 against what a real one answered to its maker's driver."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from drivers.lms1xx import telegrams
from drivers.lms1xx.emulator.emulator import REMISSION, Lms1xxEmulator
from drivers.lms1xx.fields import FieldWriter
from drivers.lms1xx.framing import Dialect, Telegram, TelegramFramer, encode_telegram
from drivers.lms1xx.measurement import decode_measurement
from drivers.lms1xx.telegrams import Fault, OutputRange, ScanContent, Scanning
from tests.drivers.lms1xx.recordings import recorded

LOGIN = telegrams.login(Dialect.A)
SETTINGS = (
    (telegrams.SET_SCANNING, Scanning(2500, 2500, -450000, 2250000)),
    (telegrams.SET_RANGE, OutputRange(5000, 0, 1800000)),
    (telegrams.SET_CONTENT, ScanContent(echoes=3, remission=True)),
)
READS = (
    *("DeviceIdent", "FirmwareVersion", "SCdevicestate", "ODoprh", "ODpwrc", "LocationName"),
    *("LCMstate", "STlms", "LMPscancfg", "LMPoutputRange", "LMDscandatacfg", "EIHstCola"),
    *("LIDinputstate", "field000", "field047"),
)


def ramp(t: float, n: int, increment: float) -> NDArray[np.float64]:
    return np.linspace(1.0, 5.0, n)


class Client:
    """Sends one payload after another and returns what came by then."""

    def __init__(self, dialect: Dialect = Dialect.A) -> None:
        self.emulator = Lms1xxEmulator(scan_source=ramp, dialect=dialect)
        self.dialect = dialect
        self.t = 0.0
        self._framer = TelegramFramer()

    def send(self, payload: bytes, wait: float = 0.01) -> list[Telegram]:
        self.emulator.feed(encode_telegram(payload, self.dialect), self.t)
        self.t += wait
        output = self.emulator.pop_output(self.t)
        return [telegram for item in output for telegram in self._framer.feed(item.data)]

    def fault(self, payload: bytes) -> int | None:
        (reply,) = self.send(payload)
        return telegrams.decode_fault(reply)


def test_it_answers_its_makers_driver_as_the_real_one_did(data_folder: Path) -> None:
    client = Client(Dialect.B)
    framer = TelegramFramer()
    real = [
        telegram
        for _, data in recorded(data_folder, "lms111", "laser->host")
        for telegram in framer.feed(data)
    ]
    same = ("sAN SetAccessMode", "sRA FirmwareVersion", "sAN Run", "sEA LMDscandata")
    for _, data in recorded(data_folder, "lms111", "host->laser"):
        (command,) = framer.feed(data)
        replies = client.send(command.payload)
        expected = telegrams.reply_to(command.command)
        (reply,) = [each for each in replies if each.command == expected]
        if expected in same:
            assert reply.payload == next(x.payload for x in real if x.command == expected)
    scans = [each for each in client.send(b"sRN nothing", 0.2) if each.command.startswith("sSN")]
    recorded_scan = next(each for each in real if each.command == telegrams.SCAN_SENT)
    assert len(scans) == pytest.approx(10, abs=1)
    ours, theirs = decode_measurement(scans[0]), decode_measurement(recorded_scan)
    assert ours is not None
    assert theirs is not None
    (a,), (b,) = ours.wide, theirs.wide
    assert (a.content, a.first, a.step, len(a.counts)) == (
        b.content,
        b.first,
        b.step,
        len(b.counts),
    )
    assert ours.serial == theirs.serial
    assert ours.sent - ours.counted == pytest.approx(theirs.sent - theirs.counted, abs=50)


@pytest.mark.parametrize("dialect", Dialect)
@pytest.mark.parametrize("name", READS)
def test_every_known_variable_is_read_without_a_login(dialect: Dialect, name: str) -> None:
    (reply,) = Client(dialect).send(telegrams.bare(f"sRN {name}", dialect))
    assert reply.command == f"sRA {name}"
    assert reply.data


@pytest.mark.parametrize(
    ("payload", "fault"),
    [
        (b"sRN field048", Fault.UNKNOWN_VARIABLE),
        (b"sRN nothing", Fault.UNKNOWN_VARIABLE),
        (b"sWN nothing 1", Fault.UNKNOWN_VARIABLE),
        (b"sMN nothing", Fault.UNKNOWN_METHOD),
        (b"sXX nothing", Fault.UNKNOWN_COMMAND),
        (b"sRN \xff\xfe", Fault.UNKNOWN_VARIABLE),
        (b"sMN LMCstartmeas", Fault.ACCESS_DENIED),
        (b"sMN SetAccessMode 3", Fault.INVALID_DATA),
        (b"sEN LMDscandata 2", Fault.INVALID_DATA),
        (b"sWN LMPoutputRange 1 1388 225510 FFF92230", Fault.INVALID_DATA),
    ],
)
def test_what_it_does_not_know_or_allow_is_refused_with_the_reason(
    payload: bytes, fault: Fault
) -> None:
    assert Client().fault(payload) == fault


@pytest.mark.parametrize(("command", "wanted"), SETTINGS)
def test_settings_are_written_after_a_login_only(
    command: str, wanted: Scanning | OutputRange | ScanContent
) -> None:
    client = Client()
    payload = wanted.write(FieldWriter(command, Dialect.A)).payload
    assert client.fault(payload) in (Fault.ACCESS_DENIED, Fault.WRITE_DENIED)
    client.send(LOGIN)
    assert client.fault(payload) is None
    assert client.emulator.configuration_writes == 1
    client.send(telegrams.bare(telegrams.LOGOUT, Dialect.A))
    assert client.fault(payload) in (Fault.ACCESS_DENIED, Fault.WRITE_DENIED)


def test_decimal_numbers_with_a_sign_set_the_same() -> None:
    client = Client()
    client.send(LOGIN)
    (reply,) = client.send(b"sMN mLMPsetscancfg +2500 +1 +2500 -450000 +2250000")
    assert reply.payload == b"sAN mLMPsetscancfg 0 9C4 1 9C4 FFF92230 225510"


def test_the_dialect_changes_after_the_reply_and_the_old_one_is_not_heard() -> None:
    client = Client()
    client.send(LOGIN)
    (reply,) = client.send(telegrams.switch(telegrams.SET_DIALECT, Dialect.A, 1))
    assert (reply.command, reply.dialect) == ("sWA EIHstCola", Dialect.A)
    assert client.send(telegrams.bare(telegrams.READ_SCANNING, Dialect.A)) == []
    client.dialect = Dialect.B
    (reply,) = client.send(telegrams.bare(telegrams.READ_SCANNING, Dialect.B))
    assert reply.dialect is Dialect.B


@pytest.mark.parametrize("wide", [False, True])
@pytest.mark.parametrize("dialect", Dialect)
def test_channels_are_sent_as_configured(*, wide: bool, dialect: Dialect) -> None:
    client = Client(dialect)
    client.emulator.content = ScanContent(echoes=3, remission=True, wide=wide)
    (scan,) = client.send(telegrams.bare(telegrams.READ_SCAN, dialect), 0.1)
    assert scan.command == telegrams.SCAN_READ
    measurement = decode_measurement(scan)
    assert measurement is not None
    assert [each.content for each in measurement.wide] == ["DIST1", "DIST2", "RSSI1"][: 2 + wide]
    assert [each.content for each in measurement.narrow] == ["RSSI1"][: 1 - wide]
    light = measurement.channel("RSSI1")
    assert light is not None
    assert (light.counts == REMISSION).all()


def test_of_so_many_scans_one_is_sent() -> None:
    client = Client()
    client.emulator.content = ScanContent(every=5)
    client.send(telegrams.switch(telegrams.STREAM, Dialect.A, 1))
    scans = client.send(b"sRN nothing", 1.0)[1:]
    assert len(scans) == pytest.approx(10, abs=1)


def test_a_range_shorter_than_16_mm_or_none_is_sent_as_zero() -> None:
    def scene(t: float, n: int, increment: float) -> NDArray[np.float64]:
        ranges = np.full(n, 70.0)
        ranges[:4] = (0.0, 0.015, 0.016, np.inf)
        return ranges

    client = Client()
    client.emulator = Lms1xxEmulator(scan_source=scene)
    (scan,) = client.send(telegrams.bare(telegrams.READ_SCAN, Dialect.A), 0.1)
    measurement = decode_measurement(scan)
    assert measurement is not None
    assert measurement.wide[0].counts[:5].tolist() == [0, 0, 16, 0, 0xFFFF]


def test_nobody_measures_while_no_scan_is_wanted() -> None:
    asked: list[float] = []

    def scene(t: float, n: int, increment: float) -> NDArray[np.float64]:
        asked.append(t)
        return ramp(t, n, increment)

    emulator = Lms1xxEmulator(scan_source=scene)
    emulator.advance(100.0)
    assert asked == []
    frame = encode_telegram(telegrams.bare(telegrams.READ_SCAN, Dialect.A), Dialect.A)
    emulator.feed(frame, 100.0)
    emulator.advance(100.1)
    assert len(asked) == 1
    assert asked[0] >= 100.0
