"""Random bytes and mutated traffic against every codec and against both ends of each line."""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from drivers.lms200 import telegrams
from drivers.lms200.emulator.emulator import Lms200Emulator
from drivers.lms200.errors import decode_errors
from drivers.lms200.framing import (
    HOST_ADDRESSES,
    LASER_ADDRESSES,
    Telegram,
    TelegramFramer,
    encode_telegram,
)
from drivers.lms200.measured_parts import decode_output
from drivers.lms200.measurement import MEASURING_MODES
from drivers.lms200.session import Lms200Session
from drivers.lms200.settings import LaserSettings
from drivers.lms200.telegrams import VARIANTS
from drivers.p2os.commands import Command, decode_command
from drivers.p2os.config_packet import ConfigPacket
from drivers.p2os.emulator.emulator import P2osEmulator
from drivers.p2os.emulator.firmware import Firmware
from drivers.p2os.emulator.make import PIONEER_2DX
from drivers.p2os.framing import CONTROLLER_MAX_COUNT, MAX_COUNT, PacketFramer, encode_packet
from drivers.p2os.packets import decode_packet
from drivers.p2os.robot_identity import decode_sync_reply
from drivers.p2os.session import P2osSession
from drivers.p2os.settings import BaseSettings
from tests.drivers.damaged_frame import mutated

PART = 200_000  # bytes
LONG_RUN = 10_000_000  # bytes
RANDOM_SHARE = 0.25
DAMAGED_SHARE = 0.2
CAPTURES = (
    Path(os.environ.get("PATROL_DATA", Path(__file__).parents[3] / "shared" / "data")) / "captures"
)


# --- codecs ----------------------------------------------------------------------------------


class PacketReader:
    """A P2OS framer, its packets decoded too."""

    def __init__(self, max_count: int, decode: Callable[[bytes], None]) -> None:
        self.framer = PacketFramer(max_count)
        self._decode = decode

    def feed(self, data: bytes) -> list[bytes]:
        packets = self.framer.feed(data)
        for packet in packets:
            self._decode(packet)
        return packets

    def finish(self) -> list[bytes]:
        packets = []
        while self.framer.pending:
            packets += self.framer.abandon_packet()
        return packets


class TelegramReader:
    """An LMS 200 framer, its telegrams decoded too; ACK and NAK, single bytes, left out."""

    def __init__(self, addresses: range) -> None:
        self.framer = TelegramFramer(addresses)

    def feed(self, data: bytes) -> list[bytes]:
        return self._payloads(self.framer.feed(data))

    def finish(self) -> list[bytes]:
        return self._payloads(self.framer.flush())

    def _payloads(self, items: Iterable[object]) -> list[bytes]:
        found = [item for item in items if isinstance(item, Telegram)]
        for telegram in found:
            decode_telegram(telegram)
        return [telegram.payload for telegram in found]


def decode_robot_packet(data: bytes) -> None:
    packet = decode_packet(data)
    assert packet is None or packet.encode() == data
    identity = decode_sync_reply(data)
    assert identity is None or data.startswith(identity.encode())


def decode_client_packet(data: bytes) -> None:
    command = decode_command(data)
    assert decode_command(command.encode()[3:-2]) == command


def decode_telegram(telegram: Telegram) -> None:
    for mode in MEASURING_MODES.values():
        measurement = decode_output(telegram, mode, VARIANTS[0])
        assert measurement is None or not np.isnan(measurement.ranges).any()
    telegrams.decode_text(telegram)
    telegrams.DeviceStatus.decode(telegram)
    telegrams.VariantReply.decode(telegram)
    telegrams.decode_read_configuration(telegram)
    telegrams.first_data_byte(telegram)
    for error in decode_errors(telegram):
        assert error.text


@dataclass(frozen=True)
class Codec:
    """One direction of one line: its valid frames, their reader and the receiver at its end."""

    frames: Callable[[], list[bytes]]
    reader: Callable[[], PacketReader | TelegramReader]
    listener: Callable[[], Callable[[bytes, float], object]]
    captured: tuple[tuple[str, str], ...]  # (file, direction)
    magic: bytes  # start of a frame, for many that never end
    overhead: int

    def traffic(self) -> list[bytes]:
        """Return encoded frames and, if available, recorded ones of independent programs."""
        return self.frames() + self._recorded()

    def payload(self, frame: bytes) -> bytes:
        return frame[3:-2] if self.overhead == 5 else frame[4:-2]

    def _recorded(self) -> list[bytes]:
        stream = b"".join(
            bytes.fromhex(line["hex"])
            for name, direction in self.captured
            if (CAPTURES / name).is_file()
            for line in map(json.loads, (CAPTURES / name).read_text().splitlines())
            if line["dir"] == direction
        )
        reader = self.reader()
        payloads = reader.feed(stream)
        if self.overhead == 5:
            return [encode_packet(payload) for payload in payloads]
        return [encode_telegram(payload) for payload in payloads]


def robot_frames() -> list[bytes]:
    """Return an emulated robot's packets in a session with motion and all streams."""
    emulator = P2osEmulator(PIONEER_2DX, baud=115200, firmware=Firmware.ARCOS)
    for command in (Command(0), Command(1), Command(2), Command(1, 1), Command(18, 1)):
        emulator.feed(command.encode(), 0.0)
    for number, argument in (
        (4, 1),
        (40, 2),
        (19, 2),
        (17, 2),
        (37, 2),
        (58, 1),
        (62, 2),
        (28, 1),
        (11, 300),
        (21, 20),
    ):
        emulator.feed(Command(number, argument).encode(), 0.0)
    data = b""
    for step in range(200):
        t = 0.01 * step
        emulator.turn_odometer(*emulator.advance(t))
        data += b"".join(sent.data for sent in emulator.pop_output(t))
    short = [encode_packet(ConfigPacket(name="R2").encode())]
    return short + [encode_packet(packet) for packet in PacketFramer().feed(data)]


def client_frames() -> list[bytes]:
    commands = [Command(0), Command(1), Command(2), Command(1, 1), Command(18, 1)]
    commands += [Command(number, size) for number in (5, 8, 11, 21, 23) for size in (-300, 7, 300)]
    commands += [Command(4, 1), Command(29), Command(55), Command(32, -765), Command(28, 1)]
    commands += [
        Command(3, bytes(range(1, 17))),
        Command(15, b"\x01\x20", b"\0"),
        Command(7, None, b"\x3b"),
    ]
    return [command.encode() for command in commands]


def laser_frames() -> list[bytes]:
    def scene(t: float, n: int, _increment: float) -> np.ndarray:
        ranges = 4.0 + 3.0 * np.sin(np.arange(n) / 9.0 + t)
        ranges[::37] = np.inf
        return ranges

    emulator = Lms200Emulator(baud=500000, scan_source=scene)
    data, t = b"", 0.0
    for payload in (b"\x3a", b"\x31", b"\x32", b"\x74", b"\x3b\xb4\x00\x64\x00", b"\x20\x24"):
        emulator.feed(encode_telegram(payload), t)
        t += 0.2
        data += b"".join(sent.data for sent in emulator.pop_output(t))
    payloads = TelegramReader(LASER_ADDRESSES).feed(data)
    return [encode_telegram(payload, 0x80) for payload in payloads]


def host_frames() -> list[bytes]:
    payloads = [b"\x10", b"\x31", b"\x32", b"\x3a", b"\x74", b"\x30\x01", b"\x20\x24", b"\x20\x25"]
    payloads += [b"\x20\x00" + telegrams.PASSWORD, b"\x3b\xb4\x00\x32\x00", b"\x66\x00"]
    payloads += [telegrams.write_configuration(telegrams.STANDARD_CONFIGURATION)]
    return [encode_telegram(payload) for payload in payloads]


def base_session() -> Callable[[bytes, float], object]:
    session = P2osSession(BaseSettings(baud=115200))
    session.link_up(0.0)
    for reply in (b"\x00", b"\x01", b"\x02a\0Pioneer\0p2dx\0"):
        session.feed(encode_packet(reply), 0.0)

    def feed(data: bytes, t: float) -> None:
        for state in session.feed(data, t):
            session.drive(t, state.x, state.theta)
        session.enable_motors(t)
        session.tick(t)
        session.pop_requests()

    return feed


def emulated_base() -> Callable[[bytes, float], object]:
    emulator = P2osEmulator(PIONEER_2DX, baud=115200)

    def feed(data: bytes, t: float) -> None:
        emulator.feed(data, t)
        emulator.turn_odometer(*emulator.advance(t))
        emulator.pop_output(t)

    return feed


def laser_session() -> Callable[[bytes, float], object]:
    session = Lms200Session(LaserSettings())
    session.link_up(0.0)

    def feed(data: bytes, t: float) -> None:
        session.feed(data, t)
        session.tick(t)
        session.pop_requests()

    return feed


def emulated_laser() -> Callable[[bytes, float], object]:
    emulator = Lms200Emulator(baud=500000, scan_source=lambda _t, n, _i: np.ones(n))

    def feed(data: bytes, t: float) -> None:
        emulator.feed(data, t)
        emulator.pop_output(t)

    return feed


P2OS_FILES = ("client-sim-tcp.jsonl", "client-sim-serial.jsonl")
LASER_FILES = ("client-laser.jsonl", "client-laser-halfdegree.jsonl")
CODECS = {
    "P2OS robot to client": Codec(
        robot_frames,
        lambda: PacketReader(MAX_COUNT, decode_robot_packet),
        base_session,
        tuple((name, "robot->host") for name in P2OS_FILES),
        b"\xfa\xfb",
        5,
    ),
    "P2OS client to robot": Codec(
        client_frames,
        lambda: PacketReader(CONTROLLER_MAX_COUNT, decode_client_packet),
        emulated_base,
        tuple((name, "host->robot") for name in P2OS_FILES),
        b"\xfa\xfb",
        5,
    ),
    "LMS 200 laser to host": Codec(
        laser_frames,
        lambda: TelegramReader(LASER_ADDRESSES),
        laser_session,
        (),  # recorded from a stand-in for a laser, and abridged
        b"\x02\x80",
        6,
    ),
    "LMS 200 host to laser": Codec(
        host_frames,
        lambda: TelegramReader(HOST_ADDRESSES),
        emulated_laser,
        tuple((name, "host->laser") for name in LASER_FILES),
        b"\x02\x00",
        6,
    ),
}


# --- the bytes -------------------------------------------------------------------------------


@dataclass(frozen=True)
class Fuzzed:
    """A stream, the payloads of its undamaged frames, and the number of damaged ones."""

    stream: bytes
    whole: list[bytes]
    damaged: int


def fuzzed(codec: Codec, traffic: list[bytes], size: int, rng: np.random.Generator) -> Fuzzed:
    """Return frames in random order, some damaged, with random bytes in front."""
    parts = [rng.bytes(int(RANDOM_SHARE * size))]
    length, damaged, whole = len(parts[0]), 1, []
    while length < size:
        for index in rng.integers(len(traffic), size=256):
            frame = traffic[index]
            if rng.random() < DAMAGED_SHARE:
                damaged += 1
                frame = mutated(frame, rng, frame_start(codec))
            else:
                whole.append(codec.payload(frame))
            parts.append(frame)
            length += len(frame)
    return Fuzzed(b"".join(parts), whole, damaged)


def frame_start(codec: Codec) -> Callable[[np.random.Generator], bytes]:
    """Return what draws the beginning of a frame with any length."""
    return lambda rng: codec.magic + bytes((int(rng.integers(256)), int(rng.integers(4))))


def pieces(stream: bytes, rng: np.random.Generator) -> Iterator[bytes]:
    at = 0
    while at < len(stream):
        size = int(rng.integers(1, 120))
        yield stream[at : at + size]
        at += size


# --- the tests -------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [PART, pytest.param(LONG_RUN, marks=pytest.mark.long)])
@pytest.mark.parametrize("codec", CODECS.values(), ids=CODECS)
def test_fuzzed_bytes_do_not_raise_and_lose_only_damaged_frames(codec: Codec, size: int) -> None:
    traffic = codec.traffic()
    for seed in range(size // PART):
        rng = np.random.default_rng(seed)
        part = fuzzed(codec, traffic, PART, rng)
        whole, single = codec.reader(), codec.reader()
        found = whole.feed(part.stream)
        one_by_one = [p for octet in part.stream for p in single.feed(bytes((octet,)))]
        assert one_by_one == found
        assert single.framer.counters == whole.framer.counters
        found += whole.finish()
        lost = sum((Counter(part.whole) - Counter(found)).values())
        assert lost <= part.damaged
        listen = codec.listener()
        t = 0.0
        for piece in pieces(part.stream, rng):
            t += len(piece) * 10 / 115200
            listen(piece, t)


@pytest.mark.parametrize("codec", CODECS.values(), ids=CODECS)
def test_work_is_linear_in_bytes(codec: Codec) -> None:
    """Also for the worst stream: frame starts at every byte, with long lengths, never valid."""
    longest = bytes((200,)) if codec.overhead == 5 else (700).to_bytes(2, "little")
    worst = codec.magic + longest
    bound = (MAX_COUNT + 3 if codec.overhead == 5 else 706) / len(worst) + 3
    work = []
    for copies in (2_000, 4_000, 8_000):
        reader = codec.reader()
        reader.feed(worst * copies)
        assert reader.framer.examined_bytes <= bound * len(worst) * copies
        work.append(reader.framer.examined_bytes)
    first, second = work[1] - work[0], work[2] - work[1]
    assert second == pytest.approx(2 * first, rel=0.01)
