"""Conversion of the camera's pictures into events for the agent's inbox."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable

import cv2

from drivers.camera import Picture
from drivers.camera_source import CameraSettings
from robot_agent.messages.events import BlobsSeen, Event, LinkDown, LinkUp, PictureTaken
from robot_agent.perception.band_detector import BandDetector
from robot_agent.perception.color_settings import ColorSettings

_JPEG_QUALITY = 70


class PictureReader:
    """Evaluates pictures on the camera's thread; ``put`` receives the resulting events."""

    def __init__(
        self, camera: CameraSettings, color: ColorSettings, put: Callable[[Event], None]
    ) -> None:
        self._camera = camera
        self._detector = BandDetector(camera, color)
        self._put = put
        self._next = -math.inf
        self._wanted = threading.Event()

    def request_picture(self) -> None:
        """Request the next picture as a PictureTaken event; thread-safe."""
        self._wanted.set()

    def camera_up(self, t: float) -> None:
        """Put the event that the camera is open, at t."""
        self._put(LinkUp(round(t, 6), "camera"))

    def camera_down(self, t: float, reason: str) -> None:
        """Put the event that the camera is lost, at t, with the reason."""
        self._put(LinkDown(round(t, 6), "camera", reason))

    def picture(self, picture: Picture) -> None:
        """Evaluate a picture if the configured rate allows one now, else drop it."""
        if picture.t < self._next:
            return
        self._next = max(self._next + 1.0 / self._camera.rate, picture.t)
        t, taken = round(picture.t, 6), max(round(picture.t - self._camera.delay, 6), 0.0)
        look = self._detector.look(picture.pixels)
        self._put(BlobsSeen(t, taken, look.sight, look.blobs))
        if self._wanted.is_set():
            self._wanted.clear()
            quality = [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY]
            _, jpeg = cv2.imencode(".jpg", picture.pixels, quality)
            self._put(PictureTaken(t, taken, jpeg.tobytes()))
