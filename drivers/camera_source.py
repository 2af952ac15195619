"""Opens the camera with OpenCV; finds the causes of failure, which OpenCV does not report."""

from __future__ import annotations

import os
import socket
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Protocol
from urllib.parse import urlsplit

import cv2
import msgspec

from drivers.port import CONNECT_LIMIT
from drivers.port_error import PortTrouble, explain

SILENCE_MS = 2000  # limit for opening and for reading a picture
LARGEST = 4096 * 4096
"""Pixels of a picture: the largest that the settings ask for. FFmpeg refuses 2**28 by itself."""
DEFAULT_PORTS = {"http": 80, "https": 443}
QUIET = "-8"  # FFmpeg's log level; failures show in the camera's state

_V4L2_MANUAL_EXPOSURE = 1.0


class CameraTrouble(StrEnum):
    """Why a camera gives no pictures."""

    MISSING = "missing"
    NO_PERMISSION = "no permission"
    FILTERED = "filtered"  # by the service's device filter
    BAD_ADDRESS = "bad address"
    REFUSED = "refused"  # the host answers, nothing listens at the port
    UNREACHABLE = "unreachable"
    NO_PICTURES = "no pictures"  # the source exists, but is no camera or is in use
    LOST = "lost"  # pictures ceased
    TOO_LARGE = "too large"
    OTHER = "other"


class CameraSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Address, mounting and adjustments of the camera; an empty ``url`` means no camera."""

    url: Annotated[
        str,
        msgspec.Meta(
            description="Camera: V4L2 device, http(s):// address of an MJPEG stream, or a file;"
            " empty: none"
        ),
    ] = ""
    width: Annotated[
        int,
        msgspec.Meta(
            ge=16,
            le=4096,
            description="Width asked for; the device takes the nearest it has",
            extra={"unit": "pixels"},
        ),
    ] = 320
    height: Annotated[
        int,
        msgspec.Meta(
            ge=16,
            le=4096,
            description="Height asked for; the device takes the nearest it has",
            extra={"unit": "pixels"},
        ),
    ] = 240
    exposure: Annotated[
        Annotated[float, msgspec.Meta(gt=0.0)] | None,
        msgspec.Meta(
            description="Exposure in the device's unit (V4L2: 0.1 ms); unset: fixed as it is"
        ),
    ] = None
    white_balance: Annotated[
        Annotated[int, msgspec.Meta(ge=2000, le=10000)] | None,
        msgspec.Meta(description="Colour temperature; unset: fixed as it is", extra={"unit": "K"}),
    ] = None
    mount: Annotated[
        tuple[float, float, float],
        msgspec.Meta(
            description="Place of the camera in base_link: x, y, theta; it looks level",
            extra={"unit": "m, m, rad"},
        ),
    ] = (0.10, 0.0, 0.0)
    mount_height: Annotated[
        float,
        msgspec.Meta(
            gt=0.0,
            le=3.0,
            description="Height of the lens above the floor",
            extra={"unit": "m"},
        ),
    ] = 0.30
    focal_length: Annotated[
        float,
        msgspec.Meta(
            gt=10.0,
            description="Focal length in a picture camera.width wide; `patrol calibrate camera`",
            extra={"unit": "pixels"},
        ),
    ] = 200.0
    delay: Annotated[
        float,
        msgspec.Meta(
            ge=0.0,
            le=1.0,
            description="Time from taking a picture to its arrival",
            extra={"unit": "s"},
        ),
    ] = 0.1
    rate: Annotated[
        float,
        msgspec.Meta(
            gt=0.0,
            le=60.0,
            description="Pictures looked at each second; others are dropped",
            extra={"unit": "1/s"},
        ),
    ] = 5.0


class Adjustable(Protocol):
    """A device with OpenCV's numbered properties."""

    def set(self, propId: int, value: float, /) -> bool:
        """Set a property; True means that the driver accepted it, not that it had an effect."""

    def get(self, propId: int, /) -> float:
        """Return a property's value, 0 if the device lacks it."""


class CameraError(OSError):
    """The camera gives no pictures; the message is one line with the reason and the remedy."""

    def __init__(self, message: str, trouble: CameraTrouble) -> None:
        super().__init__(message)
        self.trouble = trouble


def is_file(url: str) -> bool:
    """Whether ``url`` is a file, which ends; devices and streams are opened again after a loss."""
    return "://" not in url and Path(url).is_file()


def open_capture(settings: CameraSettings) -> cv2.VideoCapture:
    """Open the source for reading; raises CameraError naming it, the reason and the remedy."""
    url = settings.url
    _check_source(url)
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", QUIET)
    os.environ.setdefault("OPENCV_VIDEOIO_V4L_SELECT_TIMEOUT", str(SILENCE_MS // 1000))
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
        raise no_pictures(url)
    width, height = (
        int(capture.get(side)) for side in (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT)
    )
    if width * height > LARGEST:
        capture.release()
        raise CameraError(
            f"pictures from {url} have {width} x {height} pixels: set the camera to smaller ones",
            CameraTrouble.TOO_LARGE,
        )
    return capture


def _check_source(url: str) -> None:
    """Raise CameraError if the source cannot be opened: OpenCV does not report the reason."""
    parts = urlsplit(url)
    if "://" not in url:
        _check_path(Path(url))
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


def _check_path(path: Path) -> None:
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
    try:
        os.close(os.open(path, os.O_RDONLY | os.O_NONBLOCK))
    except PermissionError as error:  # the rights are there: it is the filter
        raise CameraError(str(explain(str(path), error)), CameraTrouble.FILTERED) from error
    except OSError:
        return  # OpenCV's own attempt tells why


def no_pictures(url: str) -> CameraError:
    """Return the error for a source that exists but gives no pictures."""
    return CameraError(
        f"no pictures from {url}: is it a camera, in use by another process, the path right?",
        CameraTrouble.NO_PICTURES,
    )


def fix_adjustments(device: Adjustable, settings: CameraSettings) -> tuple[str, ...]:
    """Switch automatic exposure and white balance off where possible; return which are off.

    Colours then look the same all day. Read back, because drivers accept values that they ignore.
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
