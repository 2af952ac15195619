"""The camera: one thread that opens it, grabs, keeps the newest picture, and opens it again.

Sources: a V4L2 device (``/dev/video0``), an MJPEG stream (``http://host:port/path``), or a file, of
pictures or of one. No decision of the agent uses pictures yet: the preflight grabs one.
"""

from __future__ import annotations

import os
import socket
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Protocol
from urllib.parse import urlsplit

import cv2
import msgspec
import numpy as np
from numpy.typing import NDArray

from drivers.port import CONNECT_LIMIT, PortTrouble, explain

FIRST_PAUSE = 0.25  # s before the source is opened again; doubles
LONGEST_PAUSE = 1.0  # s
SILENCE_MS = 2000  # without a picture, or for opening: the source is given up
DEFAULT_PORTS = {"http": 80, "https": 443}
QUIET = "-8"  # FFmpeg's level; what fails is told by the state, once

_V4L2_MANUAL_EXPOSURE = 1.0
_WAIT = 0.05  # s


class CameraState(StrEnum):
    """Where a camera stands."""

    CLOSED = "closed"
    OPENING = "opening"
    STREAMING = "streaming"  # pictures come
    DOWN = "down"  # opened again at ``next_try``
    ENDED = "ended"  # a file has no more pictures


class CameraTrouble(StrEnum):
    """What keeps a camera from giving pictures."""

    MISSING = "missing"
    NO_PERMISSION = "no permission"
    BAD_ADDRESS = "bad address"
    REFUSED = "refused"  # the host is there, nothing listens
    UNREACHABLE = "unreachable"
    NO_PICTURES = "no pictures"  # something is there, but no camera, or one in use
    LOST = "lost"  # pictures came and come no more
    OTHER = "other"


class CameraSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where the camera is and how it is set; an empty ``url`` means there is none.

    url: device, http:// or https:// address of an MJPEG stream, or a file
    width, height: pixels asked for; the device takes the nearest it has
    exposure: in the device's unit (V4L2: 0.1 ms); None keeps what the device has, but fixed
    white_balance: colour temperature in K; None keeps what the device has, but fixed
    """

    url: str = ""
    width: Annotated[int, msgspec.Meta(ge=16, le=4096)] = 320
    height: Annotated[int, msgspec.Meta(ge=16, le=4096)] = 240
    exposure: Annotated[float, msgspec.Meta(gt=0.0)] | None = None
    white_balance: Annotated[int, msgspec.Meta(ge=2000, le=10000)] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """One picture. ``t`` (s) is when it had arrived, by the camera's clock; exposure, coding and
    transport came before, by an amount nobody tells. ``number`` counts from 1."""

    t: float
    number: int
    pixels: NDArray[np.uint8]
    """(height, width, 3), blue, green, red."""


@dataclass(frozen=True, slots=True)
class CameraStatus:
    """A camera at one moment, for people.

    trouble, reason: what keeps it from giving pictures, and that in words with a remedy.
    next_try: when it is opened next, by its clock (s). fixed: which automatic adjustments are off.
    pictures: how many came. times_lost: how often they ceased.
    """

    state: CameraState
    trouble: CameraTrouble | None
    reason: str
    next_try: float | None
    fixed: tuple[str, ...]
    pictures: int
    times_lost: int


class Adjustable(Protocol):
    """What has OpenCV's numbered properties."""

    def set(self, propId: int, value: float, /) -> bool:
        """Set one; True says that the driver took it, not that it did anything."""

    def get(self, propId: int, /) -> float:
        """Return one, 0 where there is none."""


class CameraError(OSError):
    """No picture can be had; the message says why and what to do, in one line."""

    def __init__(self, message: str, trouble: CameraTrouble) -> None:
        super().__init__(message)
        self.trouble = trouble


class Camera:
    """Grabs on a thread of its own from ``start`` to ``close``; ``clock`` returns s.

    Every picture is taken off the source as it comes, so ``newest`` is never one that had to queue.
    """

    def __init__(
        self, settings: CameraSettings, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._settings = settings
        self._clock = clock
        self._lock = threading.Lock()
        self._newest: Picture | None = None
        self._status = CameraStatus(CameraState.CLOSED, None, "", None, (), 0, 0)
        self._closing = threading.Event()
        self._thread: threading.Thread | None = None

    @property
    def newest(self) -> Picture | None:
        """The last picture, None while none comes; whether it is new is told by its number."""
        with self._lock:
            return self._newest

    @property
    def status(self) -> CameraStatus:
        """Where the camera stands now."""
        with self._lock:
            return self._status

    def start(self) -> None:
        """Begin; may be called once."""
        self._thread = threading.Thread(target=self._run, name="camera", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the thread, which may take as long as a silent source is waited for; idempotent."""
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
                self._go_down(failure, pause)
            else:
                return
            self._closing.wait(pause)
            pause = min(2.0 * pause, LONGEST_PAUSE)

    def _open_and_grab(self) -> None:
        """Grab until told to close, or until a file has ended."""
        capture = open_capture(self._settings)
        try:
            fixed = fix_adjustments(capture, self._settings)
            frames = _Pacer(capture, self._clock) if is_file(self._settings.url) else None
            grabbed = 0
            while not self._closing.is_set():
                there, pixels = capture.read()
                if there:
                    grabbed += 1
                    self._keep(pixels, fixed)
                elif frames is not None and grabbed:
                    self._note(CameraState.ENDED)
                    return
                else:
                    raise _ceased(self._settings.url, grabbed)
                if frames is not None:
                    self._closing.wait(frames.until_next())
        finally:
            capture.release()

    def _keep(self, pixels: cv2.typing.MatLike, fixed: tuple[str, ...]) -> None:
        with self._lock:
            number = self._status.pictures + 1
            self._newest = Picture(self._clock(), number, np.asarray(pixels, dtype=np.uint8))
            self._status = replace(
                self._status,
                state=CameraState.STREAMING,
                trouble=None,
                reason="",
                fixed=fixed,
                pictures=number,
            )

    def _note(self, state: CameraState) -> None:
        """Enter a state that is nobody's fault; why the camera was down stays readable."""
        with self._lock:
            self._status = replace(self._status, state=state, next_try=None)

    def _go_down(self, failure: CameraError, pause: float) -> None:
        with self._lock:
            lost = failure.trouble is CameraTrouble.LOST
            self._newest = None
            self._status = replace(
                self._status,
                state=CameraState.DOWN,
                trouble=failure.trouble,
                reason=str(failure),
                next_try=self._clock() + pause,
                fixed=(),
                times_lost=self._status.times_lost + lost,
            )


class _Pacer:
    """Lets a file's pictures come at the rate they were taken at."""

    def __init__(self, capture: cv2.VideoCapture, clock: Callable[[], float]) -> None:
        rate = capture.get(cv2.CAP_PROP_FPS)
        self._period = 1.0 / rate if 0.1 <= rate <= 1000.0 else 0.0
        self._clock = clock
        self._next = clock()

    def until_next(self) -> float:
        """Return how long, s, to wait before the next picture."""
        self._next += self._period
        return max(0.0, self._next - self._clock())


def is_file(url: str) -> bool:
    """Tell a file, which ends, from a device or a stream, which are opened again."""
    return "://" not in url and Path(url).is_file()


def open_capture(settings: CameraSettings) -> cv2.VideoCapture:
    """Open the source for reading; raises CameraError naming it, the reason and the remedy."""
    url = settings.url
    _look_before_opening(url)
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", QUIET)
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    parameters = [cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, SILENCE_MS]
    parameters += [cv2.CAP_PROP_READ_TIMEOUT_MSEC, SILENCE_MS]
    if "://" in url or is_file(url):
        capture = cv2.VideoCapture(url, cv2.CAP_FFMPEG, parameters)
    else:
        capture = cv2.VideoCapture(url, cv2.CAP_V4L2)
        capture.set(cv2.CAP_PROP_FRAME_WIDTH, settings.width)
        capture.set(cv2.CAP_PROP_FRAME_HEIGHT, settings.height)
    if not capture.isOpened():
        capture.release()
        raise _no_pictures(url)
    return capture


def _look_before_opening(url: str) -> None:
    """Find out by ourselves what keeps a source from being opened: OpenCV does not tell."""
    parts = urlsplit(url)
    if "://" not in url:
        _look_at_path(Path(url))
        return
    if parts.scheme not in DEFAULT_PORTS or not parts.hostname:
        raise CameraError(
            f"unknown kind of camera {url}: use a device, a file or http://host:port/path",
            CameraTrouble.BAD_ADDRESS,
        )
    try:
        address = parts.hostname, parts.port or DEFAULT_PORTS[parts.scheme]
        socket.create_connection(address, CONNECT_LIMIT).close()
    except ValueError as failure:
        raise CameraError(
            f"bad port number in {url}: use http://host:port/path", CameraTrouble.BAD_ADDRESS
        ) from failure
    except OSError as failure:
        error = explain(url, failure)
        raise CameraError(str(error), _TROUBLES.get(error.trouble, CameraTrouble.OTHER)) from None


_TROUBLES = {
    PortTrouble.REFUSED: CameraTrouble.REFUSED,
    PortTrouble.UNREACHABLE: CameraTrouble.UNREACHABLE,
}


def _look_at_path(path: Path) -> None:
    if not path.exists():
        raise CameraError(
            f"no such camera: {path}; check cable and name, see /dev/v4l/by-id",
            CameraTrouble.MISSING,
        )
    if not os.access(path, os.R_OK):
        raise CameraError(
            f"permission denied on {path}: add the user to group video and log in again",
            CameraTrouble.NO_PERMISSION,
        )


def _no_pictures(url: str) -> CameraError:
    return CameraError(
        f"no pictures from {url}: is it a camera, in use by another process, the path right?",
        CameraTrouble.NO_PICTURES,
    )


def _ceased(url: str, grabbed: int) -> CameraError:
    if not grabbed:
        return _no_pictures(url)
    return CameraError(
        f"pictures from {url} ceased: unplugged, switched off, or the network is gone?",
        CameraTrouble.LOST,
    )


def fix_adjustments(device: Adjustable, settings: CameraSettings) -> tuple[str, ...]:
    """Switch automatic exposure and white balance off where the device allows, so that a colour
    looks the same all day; return which are fixed. Read back, as drivers accept what they ignore.
    """
    fixed = []
    if _set(device, cv2.CAP_PROP_AUTO_EXPOSURE, _V4L2_MANUAL_EXPOSURE) and (
        settings.exposure is None or _set(device, cv2.CAP_PROP_EXPOSURE, settings.exposure)
    ):
        fixed.append("exposure")
    if _set(device, cv2.CAP_PROP_AUTO_WB, 0.0) and (
        settings.white_balance is None
        or _set(device, cv2.CAP_PROP_WB_TEMPERATURE, float(settings.white_balance))
    ):
        fixed.append("white balance")
    return tuple(fixed)


def _set(device: Adjustable, what: int, value: float) -> bool:
    return device.set(what, value) and abs(device.get(what) - value) <= 0.05 * abs(value)


def wait_for_picture(camera: Camera, limit: float, after: int = 0) -> Picture | None:
    """Return the first picture numbered above ``after`` that is seen within ``limit`` s."""
    give_up = time.monotonic() + limit
    while (picture := camera.newest) is None or picture.number <= after:
        ended = camera.status.state is CameraState.ENDED
        if ended or time.monotonic() >= give_up:
            return None
        time.sleep(_WAIT)
    return picture
