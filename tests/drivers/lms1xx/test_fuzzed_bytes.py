"""Random bytes, damaged telegrams and commands in any order against codec, session, emulator."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

import numpy as np
import pytest

from drivers.lms1xx import telegrams
from drivers.lms1xx.emulator.emulator import Lms1xxEmulator
from drivers.lms1xx.fields import FieldWriter
from drivers.lms1xx.framing import Dialect, Telegram, TelegramFramer, encode_telegram
from drivers.lms1xx.measurement import decode_measurement
from drivers.lms1xx.scan import scan_of
from drivers.lms1xx.session import Lms1xxSession, SessionState
from drivers.lms1xx.settings import LaserSettings
from drivers.lms1xx.telegrams import OutputRange, ScanContent, Scanning
from tests.drivers.damaged_frame import mutated
from tests.drivers.lms1xx.conftest import MakeNetwork

PART = 200_000  # bytes
LONG_RUN = 10_000_000  # bytes
DAMAGED_SHARE = 0.2
BARE = (
    *(telegrams.READ_IDENTITY, telegrams.READ_CONTAMINATION, telegrams.READ_SCANNING),
    *(telegrams.READ_RANGE, telegrams.READ_CONTENT, telegrams.READ_SCAN, telegrams.READ_DIALECT),
    *(telegrams.START_MEASURING, telegrams.STOP_MEASURING, telegrams.LOGOUT),
    *("sRN STlms", "sRN nothing", "sMN nothing", "sXX"),
)
WRITES = (
    (telegrams.SET_SCANNING, Scanning(2500, 2500, -450000, 2250000)),
    (telegrams.SET_SCANNING, Scanning(5000, 5000, -450000, 2250000)),
    (telegrams.SET_SCANNING, Scanning(5000, 2500, -450000, 2250000)),
    (telegrams.SET_RANGE, OutputRange(5000, 0, 1800000)),
    (telegrams.SET_RANGE, OutputRange(1, -450000, -449999)),
    (telegrams.SET_CONTENT, ScanContent(echoes=3, remission=True, wide=True)),
    (telegrams.SET_CONTENT, ScanContent(echoes=0, remission=True, every=3)),
)


def commands(dialect: Dialect) -> list[bytes]:
    """Return frames of every command that a client may send."""
    payloads = [telegrams.bare(command, dialect) for command in BARE]
    payloads += [settings.write(FieldWriter(name, dialect)).payload for name, settings in WRITES]
    payloads += [telegrams.switch(telegrams.STREAM, dialect, on) for on in (0, 1, 7)]
    payloads += [telegrams.switch(telegrams.SET_DIALECT, dialect, number) for number in (0, 1)]
    payloads.append(telegrams.login(dialect))
    return [encode_telegram(payload, dialect) for payload in payloads]


def replies(dialect: Dialect) -> list[bytes]:
    """Return frames that a scanner sends."""

    def scene(t: float, n: int, increment: float) -> np.ndarray:
        ranges = 4.0 + 3.0 * np.sin(np.arange(n) / 9.0 + t)
        ranges[::37] = np.inf
        return ranges

    emulator = Lms1xxEmulator(scan_source=scene, dialect=dialect)
    found = []
    for step, frame in enumerate(commands(dialect)):
        emulator.feed(frame, 0.1 * step)
        emulator.dialect = dialect
        found += [item.data for item in emulator.pop_output(0.1 * step + 0.09)]
    return found


def decode(telegram: Telegram) -> None:
    """Decode a telegram as everything it might be."""
    measurement = decode_measurement(telegram)
    if measurement is not None:
        scan = scan_of(measurement, 1.0)
        assert scan is None or not np.isnan(scan.ranges).any()
    for settings in (Scanning, OutputRange, ScanContent):
        settings.decode(telegram)
    Scanning.decode_set(telegram)
    telegrams.decode_byte(telegram)
    telegrams.decode_identity(telegram)
    telegrams.decode_fault(telegram)


def frame_start(rng: np.random.Generator) -> bytes:
    """Return the beginning of a CoLa B frame with any length."""
    size = bytes((int(rng.integers(4)), int(rng.integers(256))))
    return b"\x02\x02\x02\x02\x00\x00" + size + b"sRA"


def fuzzed(
    traffic: list[bytes], size: int, rng: np.random.Generator
) -> tuple[bytes, list[bytes], int]:
    """Return a stream, its undamaged frames and the number of damaged ones."""
    parts = [rng.bytes(size // 4)]
    length, damaged, whole = len(parts[0]), 1, []
    while length < size:
        frame = traffic[int(rng.integers(len(traffic)))]
        if rng.random() < DAMAGED_SHARE:
            damaged += 1
            frame = mutated(frame, rng, frame_start)
        else:
            whole.append(frame)
        parts.append(frame)
        length += len(frame)
    return b"".join(parts), whole, damaged


def frames_of(found: Iterable[Telegram]) -> list[bytes]:
    """Return the frames of telegrams, decoding each."""
    frames = []
    for telegram in found:
        decode(telegram)
        frames.append(encode_telegram(telegram.payload, telegram.dialect))
    return frames


@pytest.mark.parametrize("size", [PART, pytest.param(LONG_RUN, marks=pytest.mark.long)])
@pytest.mark.parametrize("dialect", Dialect)
@pytest.mark.parametrize("make", [commands, replies])
def test_fuzzed_bytes_do_not_raise_and_lose_only_what_damage_swallows(
    make: object, dialect: Dialect, size: int
) -> None:
    assert callable(make)
    traffic = make(dialect)
    for seed in range(size // PART):
        rng = np.random.default_rng(seed)
        stream, whole, damaged = fuzzed(traffic, PART, rng)
        framer = TelegramFramer()
        found = frames_of(framer.feed(stream))
        single = TelegramFramer()
        one_by_one = [x for octet in stream for x in single.feed(bytes((octet,)))]
        assert len(one_by_one) == len(found)
        assert single.counters == framer.counters
        found += frames_of(framer.flush())
        lost = sum((Counter(whole) - Counter(found)).values())
        assert lost <= damaged
        session, emulator = Lms1xxSession(LaserSettings()), Lms1xxEmulator(scan_source=flat)
        session.link_up(0.0)
        at, t = 0, 0.0
        while at < len(stream):
            piece = stream[at : at + int(rng.integers(1, 400))]
            at, t = at + len(piece), t + 0.001
            session.feed(piece, t)
            session.tick(t)
            session.pop_requests()
            emulator.feed(piece, t)
            emulator.pop_output(t)


def flat(t: float, n: int, increment: float) -> np.ndarray:
    return np.full(n, 2.0)


@pytest.mark.parametrize("start", [b"\x02\x02\x02\x02\x00\x00\xff\xffsRA", b"\x02s", b"\x02"])
def test_frame_starts_that_never_end_do_not_pile_up(start: bytes) -> None:
    framer = TelegramFramer()
    found = framer.feed(start * 20_000)  # an XOR is right by chance once in 256 times
    accepted = sum(len(encode_telegram(each.payload, each.dialect)) for each in found)
    assert len(start) * 20_000 - accepted - framer.counters.discarded_bytes <= 0xFFFF + 9


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("dialect", Dialect)
def test_after_commands_in_any_order_the_session_comes_back(
    network: MakeNetwork, dialect: Dialect, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    net = network(dialect=dialect)
    either = [*commands(Dialect.A), *commands(Dialect.B)]
    for _ in range(200):
        net.emulator.feed(either[int(rng.integers(len(either)))], net.t)
        net.t += float(rng.exponential(0.02))
        net.emulator.pop_output(net.t)
    net.connect()
    net.run_until(SessionState.STREAMING, 4.0)
    net.run(3.0)
    assert net.session.state is SessionState.STREAMING
    assert net.session.trouble is None
    assert net.scans[-1].ranges.size == 541
