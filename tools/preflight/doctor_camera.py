"""Preflight of the camera: picture, rate, fixed exposure and white balance."""

from __future__ import annotations

import time

import numpy as np

from drivers.camera import Camera, CameraState, Picture, wait_for_picture
from drivers.camera_source import CameraSettings
from tools.preflight.finding import Finding, failed, ok, skipped, warning

PICTURE_LIMIT_S = 5.0  # for the first picture
LISTENING_S = 1.0
DARK = 8.0  # mean, 0 to 255, below which a picture is dark: lens cap, or night
FLAT = 3.0  # standard deviation, 0 to 255, below which a picture shows nothing
ADJUSTMENTS = ("exposure", "white balance")


class CameraExamination:
    """The camera's part of a preflight: starts at once, read ``findings`` later."""

    def __init__(self, settings: CameraSettings, limit: float = PICTURE_LIMIT_S) -> None:
        self._settings = settings
        self._limit = limit
        self._camera = Camera(settings)
        if settings.url:
            self._camera.start()

    def findings(self) -> list[Finding]:
        """Wait for pictures, close the camera and return the findings."""
        if not self._settings.url:
            return [skipped("camera", "camera.url is not set: no decision needs one yet")]
        first = wait_for_picture(self._camera, self._limit)
        if first is None:
            reason = self._camera.status.reason or "no picture"
            self._camera.close()
            return [_no_picture(reason)]
        last = self._last_picture(first)
        status = self._camera.status
        self._camera.close()
        found = [
            examine_picture(self._settings.url, last, _rate(first, last)),
            examine_adjustments(status.fixed),
        ]
        if status.broken:
            words = f"{status.broken} of {status.broken + status.pictures} cannot be read"
            found.append(warning("camera pictures", words, "check its cable and its network"))
        return found

    def _last_picture(self, first: Picture) -> Picture:
        """Return the last picture within LISTENING_S, or of a file that ends sooner."""
        until = time.monotonic() + LISTENING_S
        last = first
        while (left := until - time.monotonic()) > 0:
            newer = wait_for_picture(self._camera, left, after=last.number)
            last = newer or last
            if newer is None and self._camera.status.state is CameraState.ENDED:
                break
        return last


def _no_picture(reason: str) -> Finding:
    text, separator, remedy = reason.partition("; ")
    if not separator:
        text, _, remedy = reason.rpartition(": ")
    return failed("camera", text or reason, remedy or "check the camera's cable and address")


def _rate(first: Picture, last: Picture) -> float:
    """Return pictures per second; 0 for a single picture."""
    passed = last.t - first.t
    return (last.number - first.number) / passed if passed > 0.0 else 0.0


def examine_picture(url: str, picture: Picture, rate: float) -> Finding:
    """Check brightness and contrast of a picture; rate: pictures/s, 0: unknown."""
    height, width = picture.pixels.shape[:2]
    brightness, spread = float(np.mean(picture.pixels)), float(np.std(picture.pixels))
    often = f"{rate:.1f} pictures/s" if rate else "one picture"
    text = f"{url}: {often} of {width} x {height}, mean brightness {brightness:.0f} of 255"
    if brightness < DARK:
        return warning("camera", f"{text}: dark", "take the lens cap off; put the light on")
    if spread < FLAT:
        return warning("camera", f"{text}: shows nothing", "clean the lens; look what covers it")
    return ok("camera", text)


def examine_adjustments(fixed: tuple[str, ...]) -> Finding:
    """Check whether exposure and white balance are fixed, for stable colours."""
    loose = [name for name in ADJUSTMENTS if name not in fixed]
    if loose:
        return skipped("camera colours", f"{' and '.join(loose)} cannot be fixed from here")
    return ok("camera colours", "exposure and white balance fixed")
