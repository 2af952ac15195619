"""The camera: one thread that opens it, grabs, keeps the newest picture, and opens it again.

Sources: a V4L2 device (``/dev/video0``), an MJPEG stream (``http://host:port/path``), or a file, of
pictures or of one.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from drivers.camera_source import (
    SILENCE_MS,
    CameraError,
    CameraSettings,
    CameraTrouble,
    fix_adjustments,
    is_file,
    no_pictures,
    open_capture,
)

FIRST_PAUSE = 0.25  # s before the source is opened again; doubles
LONGEST_PAUSE = 1.0  # s
BROKEN_IN_A_ROW = 5
"""Broken pictures after which the source is lost; one costs no other."""

_WAIT = 0.05  # s


class CameraState(StrEnum):
    """State of a camera's thread."""

    CLOSED = "closed"
    OPENING = "opening"
    STREAMING = "streaming"  # pictures come
    DOWN = "down"  # opened again after a pause
    ENDED = "ended"  # a file has no more pictures


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """One picture. ``t`` is its arrival by the camera's clock; exposure, coding and transport came
    before, by an unknown delay. ``number`` counts from 1."""

    t: float
    number: int
    pixels: NDArray[np.uint8]
    """(height, width, 3), blue, green, red."""


@dataclass(frozen=True, slots=True)
class CameraStatus:
    """A snapshot of the camera, for people.

    trouble, reason: why there are no pictures, as a code and in words with a remedy.
    fixed: the automatic adjustments that are switched off.
    pictures: pictures received. times_lost: how often the source was lost. broken: how often a
    picture could not be read, also at each loss.
    """

    state: CameraState
    trouble: CameraTrouble | None
    reason: str
    fixed: tuple[str, ...]
    pictures: int
    times_lost: int
    broken: int = 0


class CameraListener(Protocol):
    """Callbacks of a camera, called on its thread; while one runs no picture is grabbed."""

    def camera_up(self, t: float) -> None:
        """The first picture after an outage or the start has arrived; called before ``picture``."""

    def camera_down(self, t: float, reason: str) -> None:
        """No pictures come, for ``reason``; called again only when the reason changes."""

    def picture(self, picture: Picture) -> None:
        """A picture has arrived."""


class Camera:
    """Grabs pictures on its own thread from ``start`` to ``close``; ``clock`` returns seconds.

    Every picture is read from the source as it arrives, so ``newest`` has not waited in a queue.
    """

    def __init__(
        self,
        settings: CameraSettings,
        clock: Callable[[], float] = time.monotonic,
        listener: CameraListener | None = None,
    ) -> None:
        self._settings = settings
        self._clock = clock
        self._listener = listener
        self._reported: str | None = None  # reason last reported to the listener; "" while up
        self._lock = threading.Lock()
        self._newest: Picture | None = None
        self._status = CameraStatus(CameraState.CLOSED, None, "", (), 0, 0)
        self._closing = threading.Event()
        self._thread: threading.Thread | None = None

    @property
    def newest(self) -> Picture | None:
        """The last picture, None while the camera is down."""
        with self._lock:
            return self._newest

    @property
    def status(self) -> CameraStatus:
        """A snapshot of the camera now."""
        with self._lock:
            return self._status

    @property
    def alive(self) -> bool:
        """Whether the thread runs: until ``close``, a file's end or a programming error."""
        return self._thread is not None and self._thread.is_alive()

    def start(self) -> None:
        """Start the thread; may be called once."""
        self._thread = threading.Thread(target=self._run, name="camera", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the thread; blocks for up to the source's read timeout. Idempotent."""
        self._closing.set()
        if self._thread is not None:
            self._thread.join()
        self._note(CameraState.CLOSED)

    # The thread

    def _run(self) -> None:
        pause = FIRST_PAUSE
        while not self._closing.is_set():
            before = self._status.pictures
            self._note(CameraState.OPENING)
            try:
                self._open_and_grab()
            except CameraError as failure:
                if self._status.pictures > before:
                    pause = FIRST_PAUSE
                self._go_down(failure)
            else:
                return
            self._closing.wait(pause)
            pause = min(2.0 * pause, LONGEST_PAUSE)

    def _open_and_grab(self) -> None:
        """Grab until ``close`` or the end of a file; raise CameraError once the source is lost."""
        capture = open_capture(self._settings)
        try:
            fixed = fix_adjustments(capture, self._settings)
            frames = _Pacer(capture, self._clock) if is_file(self._settings.url) else None
            grabbed = broken = 0
            while not self._closing.is_set():
                begun = time.monotonic()
                there, pixels = capture.read()
                if there:
                    grabbed += 1
                    broken = 0
                    self._keep(pixels, fixed)
                elif frames is None and self._passes_over(time.monotonic() - begun, broken):
                    broken += 1
                elif frames is not None and grabbed:
                    self._note(CameraState.ENDED)
                    return
                else:
                    raise _ceased(self._settings.url, grabbed)
                if frames is not None:
                    self._closing.wait(frames.until_next())
        finally:
            capture.release()

    def _passes_over(self, waited: float, before: int) -> bool:
        """Return whether a failure to read after a wait, s, is one broken picture; count it.

        before: broken pictures in a row before this one. A source that has ended fails at once too,
        again and again.
        """
        if before == BROKEN_IN_A_ROW or 1000.0 * waited > SILENCE_MS / 2:
            return False
        with self._lock:
            self._status = replace(self._status, broken=self._status.broken + 1)
        return True

    def _keep(self, pixels: cv2.typing.MatLike, fixed: tuple[str, ...]) -> None:
        with self._lock:
            number = self._status.pictures + 1
            picture = Picture(self._clock(), number, np.asarray(pixels, dtype=np.uint8))
            self._newest = picture
            self._status = replace(
                self._status,
                state=CameraState.STREAMING,
                trouble=None,
                reason="",
                fixed=fixed,
                pictures=number,
            )
        if self._listener is not None:
            if self._reported != "":
                self._listener.camera_up(picture.t)
            self._reported = ""
            self._listener.picture(picture)

    def _note(self, state: CameraState) -> None:
        """Change the state only; the last trouble and reason stay readable."""
        with self._lock:
            self._status = replace(self._status, state=state)

    def _go_down(self, failure: CameraError) -> None:
        with self._lock:
            lost = failure.trouble is CameraTrouble.LOST
            self._newest = None
            self._status = replace(
                self._status,
                state=CameraState.DOWN,
                trouble=failure.trouble,
                reason=str(failure),
                fixed=(),
                times_lost=self._status.times_lost + lost,
            )
        if self._listener is not None and self._reported != str(failure):
            self._reported = str(failure)
            self._listener.camera_down(self._clock(), self._reported)


class _Pacer:
    """Paces the pictures of a file at its recorded frame rate."""

    def __init__(self, capture: cv2.VideoCapture, clock: Callable[[], float]) -> None:
        rate = capture.get(cv2.CAP_PROP_FPS)
        self._period = 1.0 / rate if 0.1 <= rate <= 1000.0 else 0.0
        self._clock = clock
        self._next = clock()

    def until_next(self) -> float:
        """Return the time to wait before the next picture, s."""
        self._next += self._period
        return max(0.0, self._next - self._clock())


def _ceased(url: str, grabbed: int) -> CameraError:
    if not grabbed:
        return no_pictures(url)
    return CameraError(
        f"pictures from {url} ceased: unplugged, switched off, or the network is gone?",
        CameraTrouble.LOST,
    )


def wait_for_picture(camera: Camera, limit: float, after: int = 0) -> Picture | None:
    """Wait up to ``limit`` s for a picture numbered above ``after``; None if there is none."""
    give_up = time.monotonic() + limit
    while (picture := camera.newest) is None or picture.number <= after:
        ended = camera.status.state is CameraState.ENDED
        if ended or time.monotonic() >= give_up:
            return None
        time.sleep(_WAIT)
    return picture
