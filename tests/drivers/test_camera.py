"""The camera driver on an MJPEG stream served over HTTP, on video and picture files."""

from __future__ import annotations

import os
import resource
import struct
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import cv2
import numpy as np
import pytest

from drivers.camera import BROKEN_IN_A_ROW, Camera, CameraState, wait_for_picture
from drivers.camera_source import (
    CameraError,
    CameraSettings,
    CameraTrouble,
    fix_adjustments,
    open_capture,
)
from robot_agent.config import ConfigError, format_config, parse_config

LIMIT = 15.0  # s, generous: nothing waits that long when it works
SIZE = (64, 48)


def grey(level: int) -> np.ndarray:
    return np.full((SIZE[1], SIZE[0], 3), level, np.uint8)


class PictureServer:
    """A small network camera: an MJPEG stream whose pictures count up in brightness."""

    def __init__(self, port: int = 0, period: float = 0.02) -> None:
        self.silent = threading.Event()
        self.broken: list[bytes] = []  # sent in turn, each after two whole pictures
        self.whole = True
        self.level = 0
        self.streams = 0
        server = self

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                if self.path != "/stream":
                    self.send_error(404)
                    return
                server.streams += 1
                self.send_response(200)
                self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=x")
                self.end_headers()
                try:
                    while not server.ended.wait(period):
                        if not server.silent.is_set():
                            self.wfile.write(server.part())
                except ConnectionError:
                    pass

            def log_message(self, *_: object) -> None:
                pass

        self.ended = threading.Event()
        self.http = ThreadingHTTPServer(("127.0.0.1", port), Handler)
        self.http.daemon_threads = True
        self.port = self.http.server_address[1]
        self.url = f"http://127.0.0.1:{self.port}/stream"
        self.thread = threading.Thread(target=self.http.serve_forever, args=(0.02,))
        self.thread.start()

    def part(self) -> bytes:
        self.level = (self.level + 1) % 250
        jpeg = cv2.imencode(".jpg", grey(self.level))[1].tobytes()
        if self.broken and (self.level % 3 == 0 or not self.whole):
            jpeg = self.broken[self.level // 3 % len(self.broken)]
        head = f"--x\r\nContent-Type: image/jpeg\r\nContent-Length: {len(jpeg)}\r\n\r\n"
        return head.encode() + jpeg + b"\r\n"

    def close(self) -> None:
        self.ended.set()
        self.http.shutdown()
        self.http.server_close()
        self.thread.join()


@contextmanager
def served(port: int = 0, period: float = 0.02) -> Iterator[PictureServer]:
    server = PictureServer(port, period)
    try:
        yield server
    finally:
        server.close()


@contextmanager
def running(settings: CameraSettings) -> Iterator[Camera]:
    camera = Camera(settings)
    camera.start()
    try:
        yield camera
    finally:
        camera.close()
    assert camera.status.state is CameraState.CLOSED


def wait_until(true: Callable[[], bool]) -> None:
    give_up = time.monotonic() + LIMIT
    while not true():
        assert time.monotonic() < give_up
        time.sleep(0.01)


def test_stream_gives_the_newest_picture_only() -> None:
    with served() as server, running(CameraSettings(url=server.url)) as camera:
        assert camera.newest is None
        first = wait_for_picture(camera, LIMIT)
        assert first is not None
        assert first.pixels.shape == (SIZE[1], SIZE[0], 3)
        # After a pause without a look the newest picture is the one just sent.
        wait_until(lambda: camera.status.pictures > first.number + 20)
        newest = camera.newest
        assert newest is not None
        assert newest.number > first.number + 19
        assert newest.t > first.t
        assert newest.pixels.mean() - first.pixels.mean() == pytest.approx(
            newest.number - first.number, abs=2.0
        )
        status = camera.status
        assert (status.state, status.trouble) == (CameraState.STREAMING, None)
        assert status.times_lost == 0


def test_ended_stream_is_reported_and_opened_again() -> None:
    with served() as server, running(CameraSettings(url=server.url)) as camera:
        assert wait_for_picture(camera, LIMIT)
        port = server.port
        server.close()
        wait_until(lambda: camera.status.trouble is CameraTrouble.REFUSED)
        status = camera.status
        assert status.times_lost == 1
        assert "nothing listens" in status.reason
        assert camera.newest is None, "an old picture is no picture"
        before = status.pictures
        with served(port):
            back = wait_for_picture(camera, LIMIT, after=before)
            assert back is not None
            assert camera.status.reason == ""


def test_silent_stream_times_out() -> None:
    with served() as server, running(CameraSettings(url=server.url)) as camera:
        assert wait_for_picture(camera, LIMIT)
        server.silent.set()
        wait_until(lambda: camera.status.times_lost == 1)
        assert camera.newest is None
        server.silent.clear()
        assert wait_for_picture(camera, LIMIT)
        assert server.streams >= 2


def test_camera_without_source_reports_its_trouble() -> None:
    with running(CameraSettings(url="/dev/no-such-camera")) as camera:
        wait_until(lambda: camera.status.state is CameraState.DOWN)
        status = camera.status
        assert status.trouble is CameraTrouble.MISSING


@pytest.mark.parametrize(
    ("url", "trouble"),
    [
        ("/dev/no-such-camera", CameraTrouble.MISSING),
        ("ftp://camera/stream", CameraTrouble.BAD_ADDRESS),
        ("http:///stream", CameraTrouble.BAD_ADDRESS),
        ("http://127.0.0.1:99999/stream", CameraTrouble.BAD_ADDRESS),
        ("/dev/null", CameraTrouble.NO_PICTURES),
    ],
)
def test_invalid_sources_are_refused(url: str, trouble: CameraTrouble) -> None:
    with pytest.raises(CameraError) as caught:
        open_capture(CameraSettings(url=url))
    assert caught.value.trouble is trouble
    assert url in str(caught.value)


def test_wrong_path_gives_no_pictures() -> None:
    with served() as server, pytest.raises(CameraError) as caught:
        open_capture(CameraSettings(url=server.url.replace("stream", "elsewhere")))
    assert caught.value.trouble is CameraTrouble.NO_PICTURES


def test_unreadable_device_gives_no_permission(tmp_path: Path) -> None:
    if os.geteuid() == 0:
        pytest.skip("root may read everything")
    device = tmp_path / "video0"
    device.touch(mode=0o000)
    with pytest.raises(CameraError) as caught:
        open_capture(CameraSettings(url=str(device)))
    assert caught.value.trouble is CameraTrouble.NO_PERMISSION
    assert "group video" in str(caught.value)


@pytest.fixture
def video(tmp_path: Path) -> Path:
    """Ten pictures, 50 a second."""
    path = tmp_path / "video.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 50.0, SIZE)
    for level in range(0, 200, 20):
        writer.write(grey(level))
    writer.release()
    return path


def test_video_file_plays_to_its_end(video: Path) -> None:
    with running(CameraSettings(url=str(video))) as camera:
        wait_until(lambda: camera.status.state is CameraState.ENDED)
        assert camera.status.pictures == 10
        last = camera.newest
        assert last is not None
        assert last.pixels.mean() == pytest.approx(180.0, abs=3.0)
        assert wait_for_picture(camera, LIMIT, after=10) is None, "told at once, not awaited"


def test_video_file_keeps_its_rate(video: Path) -> None:
    started = time.monotonic()
    with running(CameraSettings(url=str(video))) as camera:
        wait_until(lambda: camera.status.state is CameraState.ENDED)
        assert time.monotonic() - started >= 0.18, "ten pictures, 0.02 s apart"


def test_picture_file_gives_one_picture(tmp_path: Path) -> None:
    path = tmp_path / "still.png"
    cv2.imwrite(str(path), grey(90))
    with running(CameraSettings(url=str(path))) as camera:
        picture = wait_for_picture(camera, LIMIT)
        assert picture is not None
        assert (picture.pixels == 90).all()


def test_file_without_video_gives_no_pictures(tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("no picture here\n")
    with running(CameraSettings(url=str(path))) as camera:
        wait_until(lambda: camera.status.trouble is CameraTrouble.NO_PICTURES)


def test_file_has_no_adjustments(video: Path) -> None:
    settings = CameraSettings(url=str(video), exposure=100.0, white_balance=4500)
    capture = open_capture(settings)
    assert fix_adjustments(capture, settings) == (), "what did not take is not claimed"
    capture.release()


class CameraRegisters:
    """A V4L2 camera's adjustments without its sensor; refused ones keep their value."""

    def __init__(self, refused: set[int]) -> None:
        self.values: dict[int, float] = {}
        self.refused = refused

    def set(self, number: int, value: float) -> bool:
        if number not in self.refused:
            self.values[number] = value
        return True  # drivers accept what they ignore

    def get(self, number: int) -> float:
        return self.values.get(number, 3.0)


@pytest.mark.parametrize(
    ("refused", "fixed"),
    [
        (set(), ("exposure", "white balance")),
        ({cv2.CAP_PROP_AUTO_EXPOSURE}, ("white balance",)),
        ({cv2.CAP_PROP_WB_TEMPERATURE}, ("exposure",)),
    ],
)
def test_fixed_adjustments_are_those_read_back(refused: set[int], fixed: tuple[str, ...]) -> None:
    camera = CameraRegisters(refused)
    settings = CameraSettings(url="/dev/video0", exposure=150.0, white_balance=4500)
    assert fix_adjustments(camera, settings) == fixed
    if not refused:
        assert camera.values == {
            cv2.CAP_PROP_AUTO_EXPOSURE: 1.0,
            cv2.CAP_PROP_EXPOSURE: 150.0,
            cv2.CAP_PROP_AUTO_WB: 0.0,
            cv2.CAP_PROP_WB_TEMPERATURE: 4500.0,
        }


def test_configuration_section_is_parsed() -> None:
    text = b'[camera]\nurl = "/dev/video0"\nexposure = 150.0\nwhite_balance = 4500\n'
    config = parse_config(text, "robot.toml")
    assert config.camera.exposure == 150.0
    assert parse_config(format_config(config).encode(), "printed") == config
    assert parse_config(b"", "robot.toml").camera.url == ""
    with pytest.raises(ConfigError, match=r"camera\.gain: unknown key"):
        parse_config(b"[camera]\ngain = 1\n", "robot.toml")
    with pytest.raises(ConfigError, match=r"camera\.white_balance"):
        parse_config(b"[camera]\nwhite_balance = 100\n", "robot.toml")


JPEG = cv2.imencode(".jpg", np.random.default_rng(1).integers(0, 255, (48, 64, 3), np.uint8))[1]


def claiming(width: int, height: int) -> bytes:
    """Return a picture whose head claims another size."""
    jpeg = JPEG.tobytes()
    at = jpeg.index(b"\xff\xc0")
    return jpeg[: at + 5] + struct.pack(">HH", height, width) + jpeg[at + 9 :]


def flipped(jpeg: bytes) -> bytes:
    """Return a picture with a bit in twenty of its bytes changed."""
    changed = bytearray(jpeg)
    for at in np.random.default_rng(2).integers(200, len(changed), 20):
        changed[at] ^= 0x54
    return bytes(changed)


BROKEN = [
    np.random.default_rng(3).bytes(500),
    b"no picture",
    JPEG.tobytes()[:100],
    JPEG.tobytes()[:700],
    flipped(JPEG.tobytes()),
    claiming(65500, 65500),
    claiming(15000, 15000),
    claiming(640, 480),
    cv2.imencode(".jpg", grey(50)[:, :, 0])[1].tobytes(),
    cv2.imencode(".jpg", np.zeros((480, 640, 3), np.uint8))[1].tobytes(),
]


def test_broken_picture_costs_one_picture_and_is_counted() -> None:
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with served(period=0.005) as server, running(CameraSettings(url=server.url)) as camera:
        assert wait_for_picture(camera, LIMIT)
        server.broken = BROKEN
        wait_until(lambda: camera.status.pictures > 200)
        status = camera.status
    assert status.times_lost == 0
    assert status.broken > 20
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 100_000  # kB


def test_source_of_broken_pictures_alone_is_lost() -> None:
    with served(period=0.005) as server, running(CameraSettings(url=server.url)) as camera:
        assert wait_for_picture(camera, LIMIT)
        server.broken, server.whole = BROKEN[:1], False
        wait_until(lambda: camera.status.times_lost == 1)
        assert camera.status.broken >= BROKEN_IN_A_ROW
        server.whole = True
        assert wait_for_picture(camera, LIMIT)


def test_pictures_that_are_too_large_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "huge.jpg"
    path.write_bytes(cv2.imencode(".jpg", np.zeros((8, 16_400), np.uint8))[1].tobytes())
    assert open_capture(CameraSettings(url=str(path))).isOpened()
    path.write_bytes(cv2.imencode(".jpg", np.zeros((4100, 4100), np.uint8))[1].tobytes())
    with pytest.raises(CameraError, match="4100 x 4100 pixels: set the camera") as caught:
        open_capture(CameraSettings(url=str(path)))
    assert caught.value.trouble is CameraTrouble.TOO_LARGE
