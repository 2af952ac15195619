"""A camera under the virtual clock: pictures are rendered, read and delivered when due."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from drivers.camera import Picture
from drivers.camera_source import CameraSettings
from robot_agent.messages.events import Event
from robot_agent.perception.color_settings import ColorSettings
from robot_agent.perception.picture_reader import PictureReader


class LockstepCamera:
    """Takes a picture at the camera's rate and delivers its event after the camera's delay."""

    def __init__(
        self,
        take: Callable[[float], NDArray[np.uint8]],
        camera: CameraSettings,
        color: ColorSettings,
    ) -> None:
        self._take = take
        self._settings = camera
        self._events: list[Event] = []
        self._picture_reader = PictureReader(camera, color, self._events.append)
        self._taken: deque[Picture] = deque()
        self._number = 0
        self._next = 0.0
        self._up = False

    def request_picture(self) -> None:
        """Send the next picture too."""
        self._picture_reader.request_picture()

    def advance(self, t: float) -> None:
        """Take a picture if one is due at ``t``."""
        if t < self._next:
            return
        self._next = t + 1.0 / self._settings.rate
        self._number += 1
        self._taken.append(Picture(t + self._settings.delay, self._number, self._take(t)))

    def arrivals(self, t: float) -> list[Event]:
        """Return the events that reach the agent by ``t``."""
        while self._taken and self._taken[0].t <= t:
            picture = self._taken.popleft()
            if not self._up:
                self._up = True
                self._picture_reader.camera_up(picture.t)
            self._picture_reader.picture(picture)
        events = self._events[:]
        self._events.clear()
        return events
