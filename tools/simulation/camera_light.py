"""Effect of light and image sensor on a scene's colours: strength, lamp, exposure, noise.

A scene is painted with the surfaces' own colours. One lookup table per channel then applies the
light and the camera's automatic exposure, and noise drawn beforehand is added.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

BALANCE_K = 4500.0
"""Colour temperature to which the camera's white balance is fixed, K."""
_GAMMA = 2.2
_SHUTTER_LIMIT_LUX = 40.0  # with less light pictures darken: exposure is at its limit
_DARKEST_NOISE = 9.0  # counts at 10 lux; falls with the square root of the light
_MIN_NOISE = 1.2  # counts
_NOISE_PICTURES = 6


@dataclass(frozen=True, slots=True)
class Light:
    """lux: strength. kelvin: colour temperature. exposure: relative to the right exposure."""

    lux: float = 300.0
    kelvin: float = BALANCE_K
    exposure: float = 1.0

    def tables(self) -> NDArray[np.uint8]:
        """Return the lookup tables (1, 256, 3) of blue, green and red."""
        warmth = BALANCE_K / self.kelvin
        lamp = np.array((warmth**-0.9, 1.0, warmth**0.7))
        strength = self.exposure * min(self.lux / _SHUTTER_LIMIT_LUX, 1.0)
        surface = (np.arange(256)[:, None] / 255.0) ** _GAMMA
        values = np.clip(surface * lamp * strength, 0.0, 1.0) ** (1.0 / _GAMMA)
        return np.asarray(np.rint(255.0 * values)[None], dtype=np.uint8)

    @property
    def noise(self) -> float:
        """Standard deviation of the noise, counts."""
        return _MIN_NOISE + _DARKEST_NOISE * min(math.sqrt(10.0 / self.lux), 1.0)


class LitCamera:
    """Converts painted scenes to pictures; the noise of each is drawn from ``rng``."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng

    def expose(
        self, scene: NDArray[np.uint8], light: Light, smear: int = 1, blur: float = 0.6
    ) -> NDArray[np.uint8]:
        """Return the picture of a scene (height, width, 3) in a light.

        smear: horizontal motion blur, pixels, odd. blur: sigma of the lens, pixels.
        """
        seen = cv2.LUT(scene, light.tables())
        if smear > 1:
            seen = cv2.blur(seen, (smear, 1))
        seen = cv2.GaussianBlur(seen, (3, 3), blur)
        pictures = _noise_pictures(round(light.noise), *scene.shape[:2])
        noise = pictures[int(self._rng.integers(len(pictures)))]
        return np.asarray(cv2.add(seen, noise, dtype=cv2.CV_8U), dtype=np.uint8)


@lru_cache(maxsize=16)
def _noise_pictures(sigma: int, height: int, width: int) -> tuple[NDArray[np.int16], ...]:
    """Return pictures of noise; cached, the same ones at every call."""
    rng = np.random.default_rng(sigma)
    shape = (height, width, 3)
    return tuple(
        np.rint(rng.normal(0.0, sigma, shape)).astype(np.int16) for _ in range(_NOISE_PICTURES)
    )
