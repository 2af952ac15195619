"""The emulated robot as its clients meet it: byte strings of the manuals over TCP and a pty, none
of our own codecs."""

from __future__ import annotations

import os
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import serial

from drivers.p2os.model import UnknownModelError
from maps.map_folder import MapFolder, load_map_folder
from maps.pose import Pose
from robot_agent.config import find_map
from tools.cli import main
from tools.emulate import EmulateError, EmulateOptions, Emulation, parse_pose

LIMIT = 10.0  # s, generous: nothing waits that long when it works
OPEN_PLACE = Pose(8.0, 3.75, 0.0)  # in paper_lab's south corridor, heading along it

SYNC0 = bytes.fromhex("FAFB 03 00 0000")
SYNC1 = bytes.fromhex("FAFB 03 01 0001")
SYNC2 = bytes.fromhex("FAFB 03 02 0002")
OPEN = bytes.fromhex("FAFB 06 01 3B0100 023B")
CLOSE = bytes.fromhex("FAFB 03 02 0002")
CONFIG = bytes.fromhex("FAFB 06 12 3B0100 133B")
ENABLE = bytes.fromhex("FAFB 06 04 3B0100 053B")
SETA_300 = bytes.fromhex("FAFB 06 05 3B2C01 313C")
SETV_400 = bytes.fromhex("FAFB 06 06 3B9001 963C")
SONAR_ON = bytes.fromhex("FAFB 06 1C 3B0100 1D3B")
VEL_300 = bytes.fromhex("FAFB 06 0B 3B2C01 373C")
STOP = bytes.fromhex("FAFB 03 1D 001D")
JUNK = b"WMS2\r"  # what a well-known client writes first, for an old radio modem


@pytest.fixture(scope="module")
def folder() -> MapFolder:
    return load_map_folder(find_map("paper_lab", Path()))


@contextmanager
def emulated(folder: MapFolder, options: EmulateOptions) -> Iterator[dict[str, str]]:
    """Run an emulated robot on a thread; give its URLs."""
    ended = threading.Event()
    with Emulation(folder, options) as emulation:
        thread = threading.Thread(target=emulation.run, args=(lambda: not ended.is_set(),))
        thread.start()
        try:
            yield emulation.urls
        finally:
            ended.set()
            thread.join()


class ManualClient:
    """A P2OS client written from the manual's rules alone."""

    def __init__(self, url: str) -> None:
        host, port = url.removeprefix("socket://").split(":")
        self.socket = socket.create_connection((host, int(port)), timeout=LIMIT)
        self.buffer = b""

    def __enter__(self) -> ManualClient:
        return self

    def __exit__(self, *_: object) -> None:
        self.socket.close()

    def send(self, packet: bytes) -> None:
        self.socket.sendall(packet)

    def packet(self, wanted: Callable[[bytes], bool] = lambda _: True) -> bytes:
        """Return the data of the next packet that is wanted."""
        give_up = time.monotonic() + LIMIT
        while time.monotonic() < give_up:
            while (data := self._take()) is not None:
                if wanted(data):
                    return data
            received = self.socket.recv(1000)
            assert received, "hung up"
            self.buffer += received
        raise AssertionError("no such packet")

    def _take(self) -> bytes | None:
        start = self.buffer.find(b"\xfa\xfb")
        if start < 0 or len(self.buffer) < start + 3:
            return None
        end = start + 3 + self.buffer[start + 2]
        if len(self.buffer) < end:
            return None
        data, checksum = self.buffer[start + 3 : end - 2], self.buffer[end - 2 : end]
        self.buffer = self.buffer[end:]
        total = sum(struct.unpack(f">{len(data) // 2}H", data[: len(data) // 2 * 2])) & 0xFFFF
        if len(data) % 2:
            total ^= data[-1]
        assert checksum == total.to_bytes(2, "big")
        return data

    def shake_hands(self) -> list[bytes]:
        """Connect as the manual says; return the robot's name, class and subclass."""
        self.send(SYNC0)
        assert self.packet() == b"\x00"
        self.send(SYNC1)
        assert self.packet() == b"\x01"
        self.send(SYNC2)
        reply = self.packet()
        assert reply[0] == 2
        self.send(OPEN)
        return reply[1:].split(b"\0")[:3]

    def sip(self, wanted: Callable[[bytes], bool] = lambda _: True) -> bytes:
        return self.packet(lambda data: data[0] in (0x32, 0x33) and wanted(data))

    def drive_until(self, wanted: Callable[[bytes], bool]) -> bytes:
        """Ask for 0.3 m/s on every report, until one is wanted."""

        def there(sip: bytes) -> bool:
            self.send(VEL_300)
            return wanted(sip)

        return self.sip(there)


def test_independent_client_over_tcp(folder: MapFolder) -> None:
    with emulated(folder, EmulateOptions(p2os="tcp:0", pose=OPEN_PLACE)) as urls:
        with ManualClient(urls["p2os"]) as client:
            client.send(JUNK)
            assert client.shake_hands() == [b"Emulated", b"Pioneer", b"p2dx"]
            first = client.sip()
            assert struct.unpack_from("<HHh", first, 1) == (0, 0, 0)
            assert first[11] > 100, "battery in decivolts"

            client.send(CONFIG)
            config = client.packet(lambda data: data[0] == 0x20)
            assert config[1:].split(b"\0")[:2] == [b"Pioneer", b"p2dx"]

            for packet in (SETA_300, SETV_400, SONAR_ON, ENABLE):
                client.send(packet)
            client.sip(lambda sip: bool(struct.unpack_from("<H", sip, 16)[0] & 1))  # motors on
            assert client.drive_until(lambda sip: x_counts(sip) >= 30)[0] == 0x33  # moving

            heard: set[int] = set()

            def whole_ring_heard(sip: bytes) -> bool:
                heard.update(sonar_numbers(sip))
                return heard == set(range(16))

            client.drive_until(whole_ring_heard)

            client.send(STOP)
            client.sip(lambda sip: sip[0] == 0x32)
            client.send(CLOSE)

        with reconnected(urls["p2os"]) as again:
            again.shake_hands()
            assert x_counts(again.sip()) == 0, "a new session starts at zero"


def reconnected(url: str) -> ManualClient:
    """Connect again right after leaving; refused while the first connection is being buried."""
    give_up = time.monotonic() + LIMIT
    while True:
        client = ManualClient(url)
        client.socket.settimeout(0.05)
        try:
            refused = client.socket.recv(1) == b""
        except TimeoutError:
            client.socket.settimeout(LIMIT)
            return client
        except ConnectionError:
            refused = True
        client.socket.close()
        assert refused
        assert time.monotonic() < give_up, "never let in again"


def x_counts(sip: bytes) -> int:
    return int(struct.unpack_from("<H", sip, 1)[0])


def sonar_numbers(sip: bytes) -> set[int]:
    return {sip[20 + 3 * i] for i in range(sip[19])}


def telegram(payload: bytes) -> bytes:
    """Frame a command to a laser as the listing says: STX, address 0, length, data, CRC."""
    frame = b"\x02\x00" + struct.pack("<H", len(payload)) + payload
    crc, previous = 0, 0
    for octet in frame:
        crc = ((crc << 1) ^ 0x8005 if crc & 0x8000 else crc << 1) & 0xFFFF
        crc ^= octet | previous << 8
        previous = octet
    return frame + struct.pack("<H", crc)


def test_laser_client_on_the_pty(folder: MapFolder) -> None:
    with (
        emulated(folder, EmulateOptions(pose=OPEN_PLACE)) as urls,
        serial.Serial(urls["lms200"], 9600, timeout=LIMIT) as line,
    ):
        for command, reply in (
            (b"\x20\x25", b"\x06\x02\x80\x03\x00\xa0\x00\x10"),  # stop any stream
            (b"\x3b\xb4\x00\x32\x00", b"\x06\x02\x80\x07\x00\xbb\x01\xb4\x00\x32\x00\x10"),
            (b"\x3b\xb4\x00\x64\x00", b"\x06\x02\x80\x07\x00\xbb\x01\xb4\x00\x64\x00\x10"),
            (b"\x20\x00SICK_LMS", b"\x06\x02\x80\x03\x00\xa0\x00\x10"),  # installation mode
            (b"\x20\x40", b"\x06\x02\x80\x03\x00\xa0\x00\x10"),  # 38400 baud
        ):
            line.write(telegram(command))
            assert line.read(len(reply) + 2)[:-2] == reply
        line.baudrate = 38400
        line.write(telegram(b"\x20\x24"))
        assert line.read(10)[:-2] == b"\x06\x02\x80\x03\x00\xa0\x00\x10"
        for _ in range(3):
            scan = line.read(372)
            assert scan[:5] == b"\x02\x80\x6e\x01\xb0"
            count = struct.unpack_from("<H", scan, 5)[0]
            assert count & 0x3FFF == 181
            ahead = struct.unpack_from("<H", scan, 7 + 2 * 90)[0] & 0x1FFF
            assert ahead > 300, "the corridor lies ahead"


def test_command_prints_urls_and_ends_on_a_signal() -> None:
    with subprocess.Popen(
        [sys.executable, "-m", "tools.cli", "emulate", "--p2os", "tcp:0"],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    ) as process:
        assert process.stdout is not None
        urls = dict(process.stdout.readline().split() for _ in range(2))
        assert urls["p2os"].startswith("socket://127.0.0.1:")
        assert os.path.exists(urls["lms200"])  # noqa: PTH110 - a device name
        process.send_signal(signal.SIGTERM)
        assert process.wait(LIMIT) == 0


def test_other_models_have_their_own_subclass(folder: MapFolder) -> None:
    options = EmulateOptions(model="p2at", p2os="tcp:0", pose=OPEN_PLACE)
    with emulated(folder, options) as urls, ManualClient(urls["p2os"]) as client:
        assert client.shake_hands()[2] == b"p2at"


def test_free_place_is_chosen_by_seed(folder: MapFolder) -> None:
    places = []
    for seed in (1, 1, 2):
        with Emulation(folder, EmulateOptions(seed=seed)) as emulation:
            places.append(emulation.rig.body.pose)
    assert places[0] == places[1] != places[2]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (EmulateOptions(p2os="serial"), "--p2os serial: is neither pty nor tcp:PORT"),
        (EmulateOptions(lms200="tcp:70000"), "--lms200 tcp:70000"),
        (EmulateOptions(pose=Pose(0.0, 0.0, 0.0)), "--pose: robot 0 at .* stands in a wall"),
    ],
)
def test_what_cannot_be_emulated(folder: MapFolder, options: EmulateOptions, words: str) -> None:
    with pytest.raises(EmulateError, match=words):
        Emulation(folder, options)


def test_taken_tcp_port(folder: MapFolder) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        number = taken.getsockname()[1]
        with pytest.raises(EmulateError, match="choose another port"):
            Emulation(folder, EmulateOptions(p2os=f"tcp:{number}"))


def test_unknown_model(folder: MapFolder) -> None:
    with pytest.raises(UnknownModelError, match="p2dx"):
        Emulation(folder, EmulateOptions(model="r2d2"))


def test_pose_option() -> None:
    pose = parse_pose("4.0,3.7,90")
    assert pose == pytest.approx((4.0, 3.7, 1.5708), abs=1e-4)
    for text in ("4.0,3.7", "a,b,c", "nan,0,0"):
        with pytest.raises(EmulateError, match="--pose"):
            parse_pose(text)


def test_bad_option_is_one_line_and_status_1(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["emulate", "--pose", "here"]) == 1
    assert capsys.readouterr().err == (
        "patrol emulate: --pose here: is not X,Y,DEG; use e.g. 4.0,3.7,90\n"
    )
