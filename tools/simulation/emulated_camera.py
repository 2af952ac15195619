"""The camera of an emulated robot as an MJPEG stream, in a light that changes."""

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
from tools.simulation.camera_light import Light, LitCamera
from tools.simulation.camera_view import CameraView, posters_on_walls
from tools.simulation.robot_body import RobotBody
from tools.simulation.truth.camera_truth import BandTruth, CameraTruth
from tools.simulation.truth.truth import load_truth
from tools.simulation.world import World

PICTURE_PERIOD_S = 0.2
PATH = "/camera.mjpeg"
_BOUNDARY = "picture"
_DAYLIGHT_PERIOD_S = 240.0
_STRENGTHS = (60.0, 1200.0)  # lux, darkest and brightest of a period
_LAMPS = (3200.0, 6200.0)  # K, likewise


class EmulatedCamera:
    """Renders pictures from a robot; light and noise are deterministic under a seed."""

    def __init__(
        self,
        world: World,
        body: RobotBody,
        camera: CameraTruth | None = None,
        band: BandTruth | None = None,
        seed: int = 0,
    ) -> None:
        """Make the camera of a body; camera and band are by default those of ``plain``."""
        posters = posters_on_walls(world)
        self._body = body
        plain = load_truth("plain").robot
        self._view = CameraView(world, camera or plain.camera, band or plain.band, posters)
        self._lit = LitCamera(np.random.default_rng((seed, body.index)))

    def picture_at(self, t: float, pose: Pose | None = None) -> NDArray[np.uint8]:
        """Return the picture (height, width, 3; blue, green, red) taken at ``t``.

        pose: map_from_base at ``t``, instead of the body's present one.
        """
        scene = self._view.scene(pose or self._body.pose, self._body)
        return self._lit.expose(scene, light_at(t))


def light_at(t: float) -> Light:
    """Return the light in the building at ``t``; strength and lamp colour vary."""
    phase = 0.5 - 0.5 * math.cos(math.tau * t / _DAYLIGHT_PERIOD_S)
    darkest, brightest = _STRENGTHS
    return Light(
        lux=darkest * (brightest / darkest) ** phase,
        kelvin=_LAMPS[0] + (_LAMPS[1] - _LAMPS[0]) * phase,
        exposure=1.0 + 0.2 * math.sin(math.tau * t / 17.0),
    )


class Feed:
    """The newest picture, for any number of clients."""

    def __init__(self) -> None:
        self.ended = False
        self.clients = 0
        self._changed = threading.Condition()
        self._jpeg = b""
        self._number = 0

    def show(self, jpeg: bytes) -> None:
        """Publish a new picture."""
        with self._changed:
            self._jpeg = jpeg
            self._number += 1
            self._changed.notify_all()

    def end(self) -> None:
        """End the stream of all clients."""
        with self._changed:
            self.ended = True
            self._changed.notify_all()

    def add_client(self) -> None:
        """Count a client in."""
        with self._changed:
            self.clients += 1

    def remove_client(self) -> None:
        """Count a client out."""
        with self._changed:
            self.clients -= 1

    def picture_after(self, number: int) -> tuple[int, bytes]:
        """Wait for a picture newer than ``number``; return number and JPEG, empty at the end."""
        with self._changed:
            self._changed.wait_for(lambda: self.ended or self._number > number)
            return self._number, b"" if self.ended else self._jpeg


class _Server(ThreadingHTTPServer):
    """An HTTP server that gives its handlers the feed."""

    daemon_threads = True

    def __init__(self, address: tuple[str, int], feed: Feed) -> None:
        super().__init__(address, _Handler)
        self.feed = feed


class _Handler(BaseHTTPRequestHandler):
    """Streams pictures to one client until either side closes."""

    server: _Server

    def do_GET(self) -> None:
        """Serve the stream at PATH."""
        if self.path != PATH:
            self.send_error(HTTPStatus.NOT_FOUND, f"the pictures are at {PATH}")
            return
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", f"multipart/x-mixed-replace; boundary={_BOUNDARY}")
        self.end_headers()
        self.server.feed.add_client()
        try:
            self._stream()
        except ConnectionError:
            pass  # the client has disconnected
        finally:
            self.server.feed.remove_client()

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
        """Log nothing."""


class CameraServer:
    """Serves pictures as an MJPEG stream on localhost; ``port`` 0 takes any free one.

    ``pump`` takes a picture when one is due and a client is connected. Raises OSError if the port
    is in use.
    """

    def __init__(self, take: Callable[[float], NDArray[np.uint8]], port: int = 0) -> None:
        self._take = take
        self._feed = Feed()
        self._next = -math.inf
        self._server = _Server(("127.0.0.1", port), self._feed)
        self.url = f"http://127.0.0.1:{self._server.server_address[1]}{PATH}"
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.1,), daemon=True)
        self._thread.start()

    def pump(self, t: float) -> None:
        """Publish a picture at ``t`` if one is due and a client is connected."""
        if t < self._next or not self._feed.clients:
            return
        self._next = t + PICTURE_PERIOD_S
        done, jpeg = cv2.imencode(".jpg", self._take(t))
        assert done, "a picture of ours can be coded"
        self._feed.show(jpeg.tobytes())

    def close(self) -> None:
        """Disconnect all clients and stop the server."""
        self._feed.end()
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()
