"""Where pictures come from: OpenCV opens it, and what OpenCV does not tell is found out before."""

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

SILENCE_MS = 2000  # without a picture, or for opening: the source is given up
DEFAULT_PORTS = {"http": 80, "https": 443}
QUIET = "-8"  # FFmpeg's level; what fails is told by the state, once

_V4L2_MANUAL_EXPOSURE = 1.0


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
    """Where the camera is and how it is set; an empty ``url`` means there is none."""

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


def is_file(url: str) -> bool:
    """Tell a file, which ends, from a device or a stream, which are opened again."""
    return "://" not in url and Path(url).is_file()


def open_capture(settings: CameraSettings) -> cv2.VideoCapture:
    """Open the source for reading; raises CameraError naming it, the reason and the remedy."""
    url = settings.url
    _look_before_opening(url)
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


def no_pictures(url: str) -> CameraError:
    """Return the error that says that something is there, but no pictures."""
    return CameraError(
        f"no pictures from {url}: is it a camera, in use by another process, the path right?",
        CameraTrouble.NO_PICTURES,
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
