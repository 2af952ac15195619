"""Real scanners' byte streams against the values that are stated of them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from drivers.lms1xx import telegrams
from drivers.lms1xx.framing import Dialect, Telegram, TelegramFramer, encode_telegram
from drivers.lms1xx.measurement import Measurement, decode_measurement, encode_measurement
from drivers.lms1xx.scan import scan_of
from drivers.lms1xx.telegrams import OutputRange, ScanContent
from drivers.scan import Scan
from tests.drivers.lms1xx.recordings import DEVICES, Device, recorded

each_device = pytest.mark.parametrize("device", DEVICES, ids=lambda device: device.name)


def measurements(data_folder: Path, device: Device) -> list[tuple[float, Measurement]]:
    framer = TelegramFramer()
    found = []
    for t, data in recorded(data_folder, device.name, "laser->host"):
        for telegram in framer.feed(data):
            if telegram.command == telegrams.SCAN_SENT:
                measurement = decode_measurement(telegram)
                assert measurement is not None
                found.append((t, measurement))
    assert framer.counters.discarded_bytes == 0
    assert not framer.pending
    return found


def first_scan(data_folder: Path, device: Device) -> Scan:
    t, measurement = measurements(data_folder, device)[0]
    scan = scan_of(measurement, t)
    assert scan is not None
    return scan


@each_device
def test_every_scan_is_decoded(data_folder: Path, device: Device) -> None:
    found = measurements(data_folder, device)
    assert len(found) == device.scans
    for t, measurement in found:
        assert measurement.serial == device.serial
        scan = scan_of(measurement, t)
        assert scan is not None
        assert scan.ranges.shape == (device.values,)
        assert not np.isnan(scan.ranges).any()
        assert 0.0 < t - scan.t < 1.0 / device.rate


@each_device
def test_the_first_scan_is_as_stated(data_folder: Path, device: Device) -> None:
    scan = first_scan(data_folder, device)
    millimetres = np.rint(scan.ranges * 1000.0).astype(int)
    assert math.degrees(scan.angle_min) + 90.0 == pytest.approx(device.first)
    assert math.degrees(scan.angle_increment) == pytest.approx(device.step)
    assert 1.0 / scan.turn_time == pytest.approx(device.rate)
    assert (millimetres.min(), np.median(millimetres), millimetres.max()) == (
        device.lowest,
        device.median,
        device.highest,
    )
    assert tuple(millimetres[:3]) == device.first_three
    assert tuple(millimetres[-3:]) == device.last_three
    assert scan.status == 0
    assert not scan.specials.any()


@each_device
def test_scans_follow_each_other_at_the_stated_rate(data_folder: Path, device: Device) -> None:
    counted = [measurement.counted for _, measurement in measurements(data_folder, device)]
    periods = np.diff(np.array(counted)) % (1 << 32)
    assert np.median(periods) * 1e-6 == pytest.approx(1.0 / device.rate, rel=0.02)


@each_device
def test_the_same_scan_in_the_other_dialect_is_the_same(data_folder: Path, device: Device) -> None:
    t, measurement = measurements(data_folder, device)[0]
    payload = encode_measurement(measurement, telegrams.SCAN_READ, Dialect.A)
    (telegram,) = TelegramFramer().feed(encode_telegram(payload, Dialect.A))
    assert telegram.command == telegrams.SCAN_READ
    again = decode_measurement(telegram)
    assert again is not None
    one, other = scan_of(measurement, t), scan_of(again, t)
    assert one is not None
    assert other is not None
    assert (one.ranges == other.ranges).all()
    assert one.t == other.t
    assert [each.content for each in (*again.wide, *again.narrow)] == [
        each.content for each in (*measurement.wide, *measurement.narrow)
    ]


@pytest.mark.parametrize(
    ("name", "wide", "narrow"),
    [
        ("lms111", ["DIST1"], []),
        ("lms511", ["DIST1"], ["RSSI1"]),
        ("tim781s", ["DIST1", "RSSI1"], []),
    ],
)
def test_channels_of_both_widths_are_told_apart(
    data_folder: Path, name: str, wide: list[str], narrow: list[str]
) -> None:
    device = next(each for each in DEVICES if each.name == name)
    _, measurement = measurements(data_folder, device)[0]
    assert [each.content for each in measurement.wide] == wide
    assert [each.content for each in measurement.narrow] == narrow


@each_device
def test_settings_read_back_are_decoded(data_folder: Path, device: Device) -> None:
    framer, replies = TelegramFramer(), dict[str, Telegram]()
    for _, data in recorded(data_folder, device.name, "laser->host"):
        replies |= {telegram.command: telegram for telegram in framer.feed(data)}
    output = OutputRange.decode(replies[telegrams.reply_to(telegrams.READ_RANGE)])
    assert output is not None
    # An LMS 111 moves the ends by less than a thousandth of a degree.
    assert output.first / telegrams.PER_DEGREE == pytest.approx(device.first, abs=1e-3)
    assert output.resolution / telegrams.PER_DEGREE == pytest.approx(device.step)
    content = ScanContent.decode(replies[telegrams.reply_to(telegrams.READ_CONTENT)])
    assert content is not None
    assert content.every == 1
    assert content.remission == (device.name != "lms111")


@each_device
def test_its_drivers_commands_are_decoded(data_folder: Path, device: Device) -> None:
    framer = TelegramFramer()
    commands = [
        telegram.command
        for _, data in recorded(data_folder, device.name, "host->laser")
        for telegram in framer.feed(data)
    ]
    assert commands[:2] == [telegrams.LOGIN, telegrams.SET_DIALECT]
    assert framer.counters.discarded_bytes == 0


def test_ages_are_those_of_the_scanners_clocks(data_folder: Path) -> None:
    """By the clock of each: half a sweep before the mark, or half a turn after it (LMS 511)."""
    ages = {
        device.name: measurements(data_folder, device)[0][0] - first_scan(data_folder, device).t
        for device in DEVICES
    }
    assert ages["lms111"] == pytest.approx(0.00313 + 0.75 * 0.02 / 2, abs=1e-5)
    assert ages["lms511"] == pytest.approx(0.04085 - 0.04 / 2, abs=1e-5)
    assert ages["tim781s"] == pytest.approx(0.00767 + 0.75 / 15 / 2, abs=1e-4)
