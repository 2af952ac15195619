"""What a camera on an emulated robot would show, as pictures and as an MJPEG stream.

One ray a column: walls as high as their distance makes them, shaded by it. No robots, no colours
to tell them by.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import cv2
import numpy as np
from numpy.typing import NDArray

from maps.pose import Pose
from tools.bench.world import World

WIDTH, HEIGHT = 320, 240  # pixels
FIELD_OF_VIEW = math.radians(50.0)  # horizontally
CAMERA_HEIGHT = 0.35  # m above the floor
WALL_HEIGHT = 2.5  # m
PICTURE_PERIOD_S = 0.1
PATH = "/camera.mjpeg"
_BOUNDARY = "picture"

_FLOOR, _CEILING, _WALL = (70, 80, 90), (225, 225, 215), np.array((150.0, 190.0, 205.0))
_FADING = 6.0  # m over which a wall's brightness falls to 1/e
_LEAST_BRIGHTNESS = 0.25


def render_view(world: World, pose: Pose) -> NDArray[np.uint8]:
    """Return the picture (height, width, 3; blue, green, red) seen from a pose, map_from_base."""
    focal = WIDTH / 2 / math.tan(FIELD_OF_VIEW / 2)
    columns = np.arange(WIDTH) - (WIDTH - 1) / 2
    bearings = -np.arctan(columns / focal)  # left of the picture is left of the robot
    ranges = world.free_ways(pose.x, pose.y, pose.theta + bearings)
    depth = np.maximum(ranges * np.cos(bearings), 0.05)
    top = HEIGHT / 2 - focal * (WALL_HEIGHT - CAMERA_HEIGHT) / depth
    bottom = HEIGHT / 2 + focal * CAMERA_HEIGHT / depth
    rows = np.arange(HEIGHT)[:, None]
    picture = np.where((rows < HEIGHT / 2)[..., None], _CEILING, _FLOOR)
    picture = np.broadcast_to(picture, (HEIGHT, WIDTH, 3)).astype(np.float64)
    brightness = np.clip(np.exp(-depth / _FADING), _LEAST_BRIGHTNESS, 1.0)
    walls = (rows >= top) & (rows < bottom)
    picture = np.where(walls[..., None], brightness[None, :, None] * _WALL, picture)
    return picture.astype(np.uint8)


class Feed:
    """The newest picture, for any number of watchers."""

    def __init__(self) -> None:
        self.ended = False
        self.watchers = 0
        self._changed = threading.Condition()
        self._jpeg = b""
        self._number = 0

    def show(self, jpeg: bytes) -> None:
        """Put up a new picture."""
        with self._changed:
            self._jpeg = jpeg
            self._number += 1
            self._changed.notify_all()

    def end(self) -> None:
        """Send everybody home."""
        with self._changed:
            self.ended = True
            self._changed.notify_all()

    def enter(self, *, leaving: bool = False) -> None:
        """Count a watcher who comes or leaves."""
        with self._changed:
            self.watchers += -1 if leaving else 1

    def picture_after(self, number: int) -> tuple[int, bytes]:
        """Wait for one newer than ``number``; return its number and JPEG, empty at the end."""
        with self._changed:
            self._changed.wait_for(lambda: self.ended or self._number > number)
            return self._number, b"" if self.ended else self._jpeg


class _Server(ThreadingHTTPServer):
    """An HTTP server that hands its handlers the feed."""

    daemon_threads = True

    def __init__(self, address: tuple[str, int], feed: Feed) -> None:
        super().__init__(address, _Handler)
        self.feed = feed


class _Handler(BaseHTTPRequestHandler):
    """Answers one watcher with pictures until either leaves."""

    server: _Server

    def do_GET(self) -> None:
        """Serve the stream at PATH."""
        if self.path != PATH:
            self.send_error(HTTPStatus.NOT_FOUND, f"the pictures are at {PATH}")
            return
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", f"multipart/x-mixed-replace; boundary={_BOUNDARY}")
        self.end_headers()
        self.server.feed.enter()
        try:
            self._stream()
        except ConnectionError:
            pass  # the watcher has left
        finally:
            self.server.feed.enter(leaving=True)

    def _stream(self) -> None:
        number = 0
        while True:
            number, jpeg = self.server.feed.picture_after(number)
            if not jpeg:
                return
            head = (
                f"--{_BOUNDARY}\r\nContent-Type: image/jpeg\r\nContent-Length: {len(jpeg)}\r\n\r\n"
            )
            self.wfile.write(head.encode() + jpeg + b"\r\n")

    def log_message(self, *_: object) -> None:
        """Say nothing: a request is no news."""


class CameraServer:
    """Serves pictures as an MJPEG stream on this machine; ``port`` 0 takes any free one.

    ``pump`` renders a picture when one is due and somebody watches. Raises OSError if the port is
    taken.
    """

    def __init__(self, world: World, pose_now: Callable[[], Pose], port: int = 0) -> None:
        self._world = world
        self._pose_now = pose_now
        self._feed = Feed()
        self._next = -math.inf
        self._server = _Server(("127.0.0.1", port), self._feed)
        self.url = f"http://127.0.0.1:{self._server.server_address[1]}{PATH}"
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.1,), daemon=True)
        self._thread.start()

    def pump(self, t: float) -> None:
        """Show what the camera sees at time ``t`` (s)."""
        if t < self._next or not self._feed.watchers:
            return
        self._next = t + PICTURE_PERIOD_S
        done, jpeg = cv2.imencode(".jpg", render_view(self._world, self._pose_now()))
        assert done, "a picture of ours can be coded"
        self._feed.show(jpeg.tobytes())

    def close(self) -> None:
        """Hang up on all who watch."""
        self._feed.end()
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()
