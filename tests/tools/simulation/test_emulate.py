"""The emulated robot against clients that send byte strings of the manuals over TCP and a pty.

The product's codecs are not used.
"""

from __future__ import annotations

import os
import signal
import socket
import struct
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import serial

from drivers.camera import Camera, wait_for_picture
from drivers.camera_source import CameraSettings
from drivers.emulation.fault_plan import FaultSpecError
from maps.map_folder import MapFolder, load_map_folder
from maps.pose import Pose
from robot_agent.config import find_map
from tools.cli import main
from tools.deploy.child_program import environment, program
from tools.simulation.base_options import BaseOptions
from tools.simulation.camera_view import CameraView
from tools.simulation.emulate import EmulateOptions, Emulation, parse_pose
from tools.simulation.emulate_error import EmulateError
from tools.simulation.laser_start import LaserStartError
from tools.simulation.truth.truth import load_truth
from tools.simulation.world import World

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
    """Run an emulated robot on a thread; yield its URLs."""
    ended = threading.Event()
    with closing(Emulation(folder, options)) as emulation:
        thread = threading.Thread(target=emulation.run, args=(lambda: not ended.is_set(),))
        thread.start()
        try:
            yield emulation.urls
        finally:
            ended.set()
            thread.join()


class SerialLine:
    """A serial port that is used like a socket."""

    def __init__(self, url: str) -> None:
        self.device = serial.Serial(url, 9600, timeout=LIMIT)

    def sendall(self, data: bytes) -> None:
        self.device.write(data)

    def recv(self, size: int) -> bytes:
        return bytes(self.device.read(1))

    def close(self) -> None:
        self.device.close()


class ManualClient:
    """A P2OS client written from the manual's rules alone."""

    def __init__(self, url: str) -> None:
        self.socket: Any
        if url.startswith("socket://"):
            host, port = url.removeprefix("socket://").split(":")
            self.socket = socket.create_connection((host, int(port)), timeout=LIMIT)
        else:
            self.socket = SerialLine(url)
        self.buffer = b""

    def close(self) -> None:
        self.socket.close()

    def send(self, packet: bytes) -> None:
        self.socket.sendall(packet)

    def packet(self, wanted: Callable[[bytes], bool] = lambda _: True) -> bytes:
        """Return the data of the next packet that satisfies the condition."""
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
        """Connect as in the manual; return the robot's name, class and subclass."""
        self.send(SYNC0)
        assert self.packet() == b"\x00"
        self.send(SYNC1)
        assert self.packet() == b"\x01"
        self.send(SYNC2)
        reply = self.packet()
        assert reply[0] == 2
        self.send(OPEN)
        return reply[1:].split(b"\0")[:3]

    def send_int(self, number: int, value: int) -> None:
        """Send a command with an integer as sign and magnitude, as clients do."""
        kind = 0x3B if value >= 0 else 0x1B
        data = bytes((number, kind)) + struct.pack("<H", abs(value))
        total = sum(struct.unpack(">2H", data)) & 0xFFFF
        self.send(b"\xfa\xfb\x06" + data + total.to_bytes(2, "big"))

    def sip(self, wanted: Callable[[bytes], bool] = lambda _: True) -> bytes:
        return self.packet(lambda data: data[0] in (0x32, 0x33) and wanted(data))

    def drive_until(self, wanted: Callable[[bytes], bool]) -> bytes:
        """Command 0.3 m/s on every report, until one satisfies the condition."""

        def there(sip: bytes) -> bool:
            self.send(VEL_300)
            return wanted(sip)

        return self.sip(there)


def test_independent_client_drives_over_tcp(folder: MapFolder) -> None:
    with emulated(folder, EmulateOptions(p2os="tcp:0", pose=OPEN_PLACE)) as urls:
        with closing(ManualClient(urls["p2os"])) as client:
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

        with closing(reconnected(urls["p2os"])) as again:
            again.shake_hands()
            assert x_counts(again.sip()) == 0, "a new session starts at zero"


# Bytes sent by a client based on the makers' own library.
VEL_MINUS_150 = bytes.fromhex("FAFB 06 0B 1B9600 A11B")
RVEL_MINUS_15 = bytes.fromhex("FAFB 06 15 1B0F00 241B")
VEL2_TURN_LEFT = bytes.fromhex("FAFB 06 20 1BFD02 1D1D")  # left -60, right +60 mm/s: -765 in all
DIGOUT_FF_05 = bytes.fromhex("FAFB 06 1E 1BFB00 191B")
SAY = bytes.fromhex("FAFB 08 0F 2B 02 0120 00 312C")  # with a NUL its length does not count
BATTERY_INFO = bytes.fromhex("FAFB 06 3E 3B0100 3F3B")
CLOSE_1 = bytes.fromhex("FAFB 06 02 3B0100 033B")
HOSTBAUD_38400 = bytes.fromhex("FAFB 06 32 3B0200 343B")
STOP_MOVING = ((11, 0), (21, 0))  # VEL, RVEL
LIMITS = ((6, 2200), (5, 300), (5, -300), (10, 150), (23, 100), (23, -100))


def speeds(sip: bytes) -> tuple[int, int]:
    left, right = struct.unpack_from("<hh", sip, 7)
    return left, right


def motors_on(sip: bytes) -> bool:
    return bool(struct.unpack_from("<H", sip, 16)[0] & 1)


def heading(sip: bytes) -> float:
    """Return degrees in 0..360."""
    return float(struct.unpack_from("<h", sip, 5)[0] * 360.0 / 4096 % 360.0)


def distance(before: bytes, after: bytes) -> float:
    """Return mm between two reports; positions count modulo 2^15."""
    steps = (
        (struct.unpack_from("<H", after, at)[0] - struct.unpack_from("<H", before, at)[0])
        for at in (1, 3)
    )
    return 0.84 * float(np.hypot(*((step + 0x4000) % 0x8000 - 0x4000 for step in steps)))


def set_up(client: ManualClient) -> None:
    """Send what such a client sends after OPEN: CONFIG at once, limits at the first report."""
    client.send(CONFIG)
    client.packet(lambda data: data[0] == 0x20)
    client.send(BATTERY_INFO)  # of later firmware: a missing reply is accepted
    client.sip()
    for number, value in LIMITS:
        client.send_int(number, value)
    for packet in (SYNC0, SONAR_ON, ENABLE):  # SYNC0 is PULSE now
        client.send(packet)
    client.sip(motors_on)


def come_to_rest(client: ManualClient) -> None:
    for number, value in STOP_MOVING:
        client.send_int(number, value)
    client.sip(lambda sip: speeds(sip) == (0, 0) and sip[0] == 0x32)


def test_bytes_of_an_aria_client_are_accepted(folder: MapFolder) -> None:
    with emulated(folder, EmulateOptions(p2os="tcp:0", pose=OPEN_PLACE)) as urls:
        with closing(ManualClient(urls["p2os"])) as client:
            client.shake_hands()
            set_up(client)
            client.send(CONFIG)
            config = client.packet(lambda data: data[0] == 0x20)
            assert struct.pack("<4H", 150, 2200, 100, 100) in config, "limits show in CONFIG"

            client.send(VEL_MINUS_150)
            client.sip(lambda sip: speeds(sip) == (-150, -150))
            come_to_rest(client)
            client.send(RVEL_MINUS_15)
            clockwise = client.sip(lambda sip: speeds(sip)[0] > 20)
            assert speeds(clockwise)[1] == -speeds(clockwise)[0]
            come_to_rest(client)
            client.send(VEL2_TURN_LEFT)
            client.sip(lambda sip: speeds(sip) == (-60, 60))
            come_to_rest(client)

            client.send_int(12, 30)  # HEAD, absolute
            client.sip(lambda sip: abs(heading(sip) - 30.0) < 1.5 and speeds(sip) == (0, 0))
            before = client.sip()
            client.send_int(8, 200)  # MOVE
            client.sip(lambda sip: sip[0] == 0x33)
            after = client.sip(lambda sip: sip[0] == 0x32)
            assert distance(before, after) == pytest.approx(200.0, abs=15.0)

            for packet in (DIGOUT_FF_05, SAY):
                client.send(packet)
            client.sip(lambda sip: sip[20 + 3 * sip[19] + 4] == 0x05)
            client.send_int(4, 0)
            client.send(CLOSE_1)

        with closing(reconnected(urls["p2os"])) as again:
            again.shake_hands()
            sip = again.sip()
            assert struct.unpack_from("<HHh", sip, 1) == (0, 0, 0)
            assert not motors_on(sip), "motors are off in every new session"
            again.send(VEL_300)
            again.sip()
            assert speeds(again.sip()) == (0, 0)


def test_serial_client_changes_the_rate_and_reconnects(folder: MapFolder) -> None:
    with emulated(folder, EmulateOptions(pose=OPEN_PLACE)) as urls:
        for _ in range(2):  # CLOSE resets the robot to its start rate
            with closing(ManualClient(urls["p2os"])) as client:
                client.send(JUNK)
                time.sleep(0.07)
                client.shake_hands()
                client.send(CONFIG)
                client.packet(lambda data: data[0] == 0x20)
                client.send(HOSTBAUD_38400)
                client.socket.device.baudrate = 38400
                client.buffer = b""
                client.send(SYNC0)
                client.sip()
                client.sip()
                client.send(CLOSE_1)
                time.sleep(0.2)


@pytest.mark.parametrize("place", ["pty", "tcp:0"])
def test_cut_line_disappears_and_returns(folder: MapFolder, place: str) -> None:
    options = EmulateOptions(p2os=place, p2os_faults="cut=1:1.5", pose=OPEN_PLACE)
    with emulated(folder, options) as urls:
        url = urls["p2os"]
        with closing(ManualClient(url)) as client:
            client.shake_hands()
            client.sip()
            # Hung up on: a socket ends or breaks, a serial port fails.
            with pytest.raises((AssertionError, OSError)):
                client.packet(lambda _: False)
        # The robot stays powered without a cable: the session is still open.
        assert first_report_again(url)[0] in (0x32, 0x33)


def first_report_again(url: str) -> bytes:
    """Try a port that was removed until it gives a report."""
    give_up = time.monotonic() + LIMIT
    while True:
        try:
            with closing(ManualClient(url)) as client:
                return client.sip()
        except (AssertionError, OSError):  # not there yet, or still being removed
            assert time.monotonic() < give_up, "never came back"
            time.sleep(0.02)


def test_fault_plan_resets_the_base(folder: MapFolder) -> None:
    options = EmulateOptions(p2os="tcp:0", p2os_faults="reset=1", pose=OPEN_PLACE)
    with emulated(folder, options) as urls, closing(ManualClient(urls["p2os"])) as client:
        client.shake_hands()
        set_up(client)
        client.socket.settimeout(0.5)
        with pytest.raises(TimeoutError):
            client.packet(lambda _: False)
        client.socket.settimeout(LIMIT)
        give_up = time.monotonic() + LIMIT
        while True:  # ignores bytes while it starts up
            assert time.monotonic() < give_up
            client.send(SYNC0)
            client.socket.settimeout(0.3)
            try:
                assert client.packet() == b"\x00"
                break
            except TimeoutError:
                continue


def test_invalid_laser_start_is_refused(folder: MapFolder) -> None:
    with pytest.raises(LaserStartError, match="melting"):
        Emulation(folder, EmulateOptions(lms200_start="melting"))


def test_invalid_faults_are_refused(folder: MapFolder) -> None:
    with pytest.raises(FaultSpecError, match="melt"):
        Emulation(folder, EmulateOptions(lms200_faults="melt=1"))


def test_camera_stream_shows_the_view(folder: MapFolder) -> None:
    with emulated(folder, EmulateOptions(camera=0, pose=OPEN_PLACE)) as urls:
        camera = Camera(CameraSettings(url=urls["camera"]))
        camera.start()
        first = wait_for_picture(camera, LIMIT)
        assert first is not None
        second = wait_for_picture(camera, LIMIT, after=first.number)
        camera.close()
        assert second is not None
        assert second.pixels.shape == (240, 320, 3)


def test_view_shows_walls_by_their_distance(folder: MapFolder) -> None:
    world = World(folder.map, np.random.default_rng(1))
    robot = load_truth("plain").robot
    view = CameraView(world, robot.camera, robot.band)
    along, across = (
        view.scene(Pose(OPEN_PLACE.x, OPEN_PLACE.y, theta)).astype(int)
        for theta in (OPEN_PLACE.theta, OPEN_PLACE.theta + np.pi / 2)
    )
    middle = 160
    wall_rows = [
        int(np.count_nonzero(np.abs(np.diff(seen[:, middle].sum(axis=1))) > 0)) >= 1
        for seen in (along, across)
    ]
    assert all(wall_rows), "a wall stands out from ceiling and floor"
    near, far = across[118, middle].sum(), along[118, middle].sum()
    assert near > far, "the side wall is nearer, so brighter, than the corridor's end"


def test_camera_port_in_use_is_refused(folder: MapFolder) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        number = taken.getsockname()[1]
        with pytest.raises(EmulateError, match=f"--camera {number}"):
            Emulation(folder, EmulateOptions(camera=number))


def reconnected(url: str) -> ManualClient:
    """Connect again right after disconnecting; refused until the first connection is closed."""
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
    """Frame a command to a laser by the listing: STX, address 0, length, data, CRC."""
    frame = b"\x02\x00" + struct.pack("<H", len(payload)) + payload
    crc, previous = 0, 0
    for octet in frame:
        crc = ((crc << 1) ^ 0x8005 if crc & 0x8000 else crc << 1) & 0xFFFF
        crc ^= octet | previous << 8
        previous = octet
    return frame + struct.pack("<H", crc)


def test_laser_client_gets_scans_on_the_pty(folder: MapFolder) -> None:
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


def scans_per_second(line: serial.Serial) -> float:
    line.reset_input_buffer()
    begin, count = time.monotonic(), 0
    while time.monotonic() - begin < 1.0:
        count += line.read(4096).count(b"\x02\x80\x6e\x01\xb0")
    return count / (time.monotonic() - begin)


def test_laser_on_tcp_has_no_rate_until_one_is_ordered(folder: MapFolder) -> None:
    options = EmulateOptions(lms200="tcp:0", lms200_start="variant=180:1", pose=OPEN_PLACE)
    with (
        emulated(folder, options) as urls,
        serial.serial_for_url(urls["lms200"], timeout=0.02) as line,
    ):
        line.write(telegram(b"\x20\x24"))
        assert scans_per_second(line) > 12.0, "9600 baud would let through 2.5 of them"
        line.write(telegram(b"\x20\x25"))
        line.write(telegram(b"\x20\x40"))
        line.write(telegram(b"\x20\x24"))
        time.sleep(0.1)
        assert 5.0 < scans_per_second(line) < 12.0


def test_laser_is_found_as_its_start_says(folder: MapFolder) -> None:
    start = "baud=38400,streaming,address=1,polluted"
    with (
        emulated(folder, EmulateOptions(lms200_start=start, pose=OPEN_PLACE)) as urls,
        serial.Serial(urls["lms200"], 38400, timeout=LIMIT) as line,
    ):
        assert line.read_until(b"\x02\x81\xd6\x02\xb0").endswith(b"\xb0")
        line.write(telegram(b"\x32"))
        assert line.read_until(b"\x06\x02\x81\x02\x00\xb2\x92").endswith(b"\x92")


def test_command_prints_urls_and_ends_on_a_signal() -> None:
    with subprocess.Popen(
        program("tools.cli", "emulate", "--p2os", "tcp:0"),
        env=environment(),
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
    options = EmulateOptions(truth=load_truth("p2at"), p2os="tcp:0", pose=OPEN_PLACE)
    with emulated(folder, options) as urls, closing(ManualClient(urls["p2os"])) as client:
        assert client.shake_hands()[2] == b"p2at"


def test_killed_client_leaves_the_robot_driving_until_the_watchdog(folder: MapFolder) -> None:
    options = EmulateOptions(p2os="tcp:0", pose=OPEN_PLACE, base=BaseOptions(watchdog=0.6))
    with emulated(folder, options) as urls:
        with closing(ManualClient(urls["p2os"])) as client:
            client.shake_hands()
            client.send(ENABLE)
            client.drive_until(lambda sip: speeds(sip)[0] > 200)
        with closing(reconnected(urls["p2os"])) as again:
            again.sip(lambda sip: speeds(sip) == (0, 0))
            again.send(SYNC0)  # PULSE to a session that is still open
            assert speeds(again.sip(lambda sip: speeds(sip)[0] > 0))[0] > 0
            again.send(CLOSE)


def test_base_that_hangs_up_does_so_after_close(folder: MapFolder) -> None:
    options = EmulateOptions(p2os="tcp:0", pose=OPEN_PLACE, base=BaseOptions(hang_up=True))
    with emulated(folder, options) as urls:
        with closing(ManualClient(urls["p2os"])) as client:
            client.shake_hands()
            client.sip()
            client.send(CLOSE)
            with pytest.raises(AssertionError, match="hung up"):
                client.packet(lambda _: False)
        with closing(reconnected(urls["p2os"])) as again:
            again.shake_hands()


def test_help_tells_of_the_watchdog(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["emulate", "--help"])
    text = " ".join(capsys.readouterr().out.split())
    assert "leaves it driving until the base's watchdog" in text
    assert "--model" in text


def test_free_place_is_chosen_by_seed(folder: MapFolder) -> None:
    places = []
    for seed in (1, 1, 2):
        with closing(Emulation(folder, EmulateOptions(seed=seed))) as emulation:
            places.append(emulation.rig.body.pose)
    assert places[0] == places[1] != places[2]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (EmulateOptions(p2os="serial"), "--p2os serial: is neither pty nor tcp:PORT"),
        (EmulateOptions(base=BaseOptions(hang_up=True)), "--hang-up: a pty has no connection"),
        (EmulateOptions(lms200="tcp:70000"), "--lms200 tcp:70000"),
        (EmulateOptions(pose=Pose(0.0, 0.0, 0.0)), "--pose: robot 0 at .* stands in a wall"),
    ],
)
def test_invalid_options_are_refused(
    folder: MapFolder, options: EmulateOptions, words: str
) -> None:
    with pytest.raises(EmulateError, match=words):
        Emulation(folder, options)


def test_tcp_port_in_use_is_refused(folder: MapFolder) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        number = taken.getsockname()[1]
        with pytest.raises(EmulateError, match="choose another port"):
            Emulation(folder, EmulateOptions(p2os=f"tcp:{number}"))


def test_pose_option_is_parsed() -> None:
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
