"""Recorded traffic of another implementation's LMS 200 driver, played to the emulated laser.

That client ignores ACKs and waits for one reply code after each of its commands.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from drivers.lms200.emulator.emulator import Lms200Emulator
from drivers.lms200.framing import HOST_ADDRESSES, Ack, Telegram, TelegramFramer, encode_telegram
from drivers.lms200.measurement import MEASURING_MODES, decode_measurement
from drivers.lms200.telegrams import Variant

POLL = 0.01  # s


def ramp(t: float, n: int, increment: float) -> NDArray[np.float64]:
    return np.linspace(1.0, 5.0, n)


@dataclass(frozen=True)
class Recorded:
    t: float
    baud: int
    data: bytes


def host_side(capture: Path) -> list[Recorded]:
    lines = [json.loads(line) for line in capture.read_text().splitlines()]
    return [
        Recorded(line["t"], line["baud"], bytes.fromhex(line["hex"]))
        for line in lines
        if line["dir"] == "host->laser"
    ]


def replies_between(emulator: Lms200Emulator, begin: float, end: float) -> list[Telegram]:
    framer = TelegramFramer()
    found: list[Telegram] = []
    t = begin
    while t < end:
        t = min(t + POLL, end)
        for item in emulator.pop_output(t):
            items = framer.feed(item.data) + framer.break_off()
            found += [i for i in items if isinstance(i, Telegram)]
    return found


@pytest.mark.parametrize(
    ("name", "count", "per_second"),
    [("client-laser.jsonl", 181, 9.38), ("client-laser-halfdegree.jsonl", 361, 4.69)],
)
def test_recorded_client_gets_every_expected_reply(
    data_folder: Path, name: str, count: int, per_second: float
) -> None:
    commands = host_side(data_folder / "captures" / name)
    waits_for = {b"\x3b": b"\xbb\x01", b"\x20\x00": b"\xa0\x00", b"\x20\x24": b"\xa0\x00"}
    waits_for |= {b"\x77": b"\xf7\x01"}
    emulator = Lms200Emulator(scan_source=ramp)
    scans: list[Telegram] = []
    answered = 0
    ends = [command.t for command in commands[1:]] + [commands[-1].t + 1.0]
    for command, end in zip(commands, ends, strict=True):
        assert command.baud == emulator.baud
        emulator.feed(command.data, command.t)
        replies = replies_between(emulator, command.t, end)
        scans += [reply for reply in replies if reply.code == 0xB0]
        for key, start in waits_for.items():
            if command.data[4:].startswith(key):
                assert any(reply.payload.startswith(start) for reply in replies)
                answered += 1
    assert answered == 4
    assert emulator.baud == 9600  # as the client leaves it

    streamed = commands[-2].t - commands[-3].t
    assert len(scans) == pytest.approx(per_second * streamed, abs=1.5)
    measurement = decode_measurement(scans[0], MEASURING_MODES[5])
    assert measurement is not None
    np.testing.assert_allclose(measurement.ranges, np.linspace(1.0, 5.0, count), atol=0.00051)


@pytest.mark.parametrize("name", ["client-laser.jsonl", "client-laser-halfdegree.jsonl"])
def test_every_byte_of_the_client_decodes_and_re_encodes(data_folder: Path, name: str) -> None:
    stream = b"".join(command.data for command in host_side(data_folder / "captures" / name))
    framer = TelegramFramer(HOST_ADDRESSES)
    telegrams = [item for item in framer.feed(stream) if isinstance(item, Telegram)]
    assert b"".join(encode_telegram(t.payload, t.address) for t in telegrams) == stream
    assert framer.counters.discarded_bytes == framer.counters.bad_checksum == 0


def in_short(kinds: list[str]) -> list[str]:
    """Scans in a row counted once."""
    pairs = zip(["", *kinds], kinds, strict=False)
    return [kind for before, kind in pairs if kind != "b0" or before != "b0"]


@pytest.mark.parametrize("name", ["client-laser.jsonl", "client-laser-halfdegree.jsonl"])
def test_recorded_client_gets_replies_in_the_recorded_order(data_folder: Path, name: str) -> None:
    capture = data_folder / "captures" / name
    lines = [json.loads(line) for line in capture.read_text().splitlines()]
    heard = [line["hex"] for line in lines if line["dir"] == "laser->host"]
    recorded = ["ack" if text == "06" else text[8:10] for text in heard]
    emulator, framer = Lms200Emulator(scan_source=ramp), TelegramFramer()
    ours: list[str] = []
    now = 0.0
    for command in [*host_side(capture), Recorded(7.0, 9600, b"")]:
        while now < command.t:
            now = min(now + POLL, command.t)
            for item in emulator.pop_output(now):
                found = framer.feed(item.data) + framer.break_off()
                ours += ["ack" if isinstance(i, Ack) else f"{i.code:02x}" for i in found]  # type: ignore[union-attr]
        emulator.feed(command.data, command.t)
    assert in_short(ours) == in_short(recorded)


def test_client_that_sends_resolution_zero_gets_scans() -> None:
    emulator = Lms200Emulator(scan_source=ramp, variant=Variant(180, 100))
    emulator.feed(bytes.fromhex("02 00 05 00 3b b4 00 00 00 5f 2d"), 0.0)
    (reply,) = replies_between(emulator, 0.0, 0.1)
    assert reply.payload == bytes.fromhex("bb 01 b4 00 64 00 10")


def test_client_that_switches_power_gets_the_power_on_telegram() -> None:
    emulator = Lms200Emulator(scan_source=ramp, boot_time=2.0)
    emulator.feed(bytes.fromhex("02 00 01 00 10 34 12"), 0.0)
    assert [reply.code for reply in replies_between(emulator, 0.0, 3.0)] == [0x91, 0x90]


def test_streaming_laser_answers_the_client_that_starts_without_stopping_it() -> None:
    emulator = Lms200Emulator(baud=38400, scan_source=ramp)
    emulator.feed(encode_telegram(b"\x20\x24"), 0.0)
    replies_between(emulator, 0.0, 1.0)
    emulator.feed(bytes.fromhex("02 00 05 00 3b b4 00 64 00 97 49"), 1.0)
    codes = [reply.code for reply in replies_between(emulator, 1.0, 2.0)]
    assert codes == [0xBB]  # the scan being sent is broken off
