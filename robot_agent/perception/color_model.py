"""The colour model: classifies pixels as the team's colour, independent of brightness.

Brightness cancels in the ratios of the three channels. In their logarithms the colour of the light
is a shift and the sensor's noise Gaussian, with a variance that grows as a pixel gets darker. A
pixel has the team's colour if its likelihood is larger than that of grey surroundings and of every
other team's colour. As that depends on the pixel alone, a table of 64 x 64 x 64 colours is computed
once.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robot_agent.perception.color_settings import ColorModelSettings, ColorSettings

MAX_DISTANCE = 9.2  # squared Mahalanobis distance from the colour: 99 % of its pixels
_BITS = 6  # of each channel in the table
_SHIFT = 8 - _BITS
_FLOOR = 6.0  # counts added to each channel: bounds the logarithms of dark pixels
_NOISE = 1.5  # counts; one sigma of noise, coding and quantization in a channel
_GREY_VARIANCE = 0.12  # of either coordinate over walls, floors, furniture and skin
_MIN_BRIGHTNESS = 18.0  # counts of the brightest channel
_ADVANTAGE = 1.5  # nats of log likelihood over grey required, as the team's colour is rare


def log_chromaticity(pixels: NDArray[np.floating]) -> NDArray[np.float64]:
    """Return (n, 2): ln(red / green), ln(blue / green) of pixels (n, 3), blue, green, red."""
    logs = np.log(pixels.astype(np.float64) + _FLOOR)
    return np.column_stack((logs[:, 2] - logs[:, 1], logs[:, 0] - logs[:, 1]))


class ColorTable:
    """Classifies pixels as the team's colour or not, by one table look-up each."""

    def __init__(self, settings: ColorSettings) -> None:
        self._table = _table(settings).astype(np.uint8) * 255

    def mask(self, picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return (height, width): 255 where a pixel has the team's colour, else 0.

        picture: (height, width, 3), blue, green, red.
        """
        coarse = picture >> _SHIFT
        index = coarse[..., 0].astype(np.int32)
        index <<= _BITS
        index |= coarse[..., 1]
        index <<= _BITS
        index |= coarse[..., 2]
        return self._table[index]


def _table(settings: ColorSettings) -> NDArray[np.bool_]:
    """Return (64^3,) whether each colour is the team's; index: blue, green, red, blue slowest."""
    steps = np.arange(1 << _BITS) * float(1 << _SHIFT) + 0.5 * ((1 << _SHIFT) - 1)
    blue, green, red = (axis.ravel() for axis in np.meshgrid(steps, steps, steps, indexing="ij"))
    place = log_chromaticity(np.column_stack((blue, green, red)))
    noise = _noise(blue, green, red)
    distance, likelihood = _fit(place, noise, settings.band)
    grey = ColorModelSettings(mean=(0.0, 0.0), covariance=(_GREY_VARIANCE, 0.0, _GREY_VARIANCE))
    mine = likelihood > _fit(place, noise, grey)[1] + _ADVANTAGE
    mine &= distance < MAX_DISTANCE
    mine &= np.maximum(np.maximum(blue, green), red) >= _MIN_BRIGHTNESS
    for other in settings.others:
        mine &= likelihood > _fit(place, noise, other)[1]
    return np.asarray(mine)


_Covariance = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]


def _noise(
    blue: NDArray[np.float64], green: NDArray[np.float64], red: NDArray[np.float64]
) -> _Covariance:
    """Return the covariance of both coordinates by the channels' noise: var, covariance, var."""
    of_blue, of_green, of_red = (
        (_NOISE / (channel + _FLOOR)) ** 2 for channel in (blue, green, red)
    )
    return of_red + of_green, of_green, of_blue + of_green


def _fit(
    place: NDArray[np.float64], noise: _Covariance, model: ColorModelSettings
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return (n,) squared Mahalanobis distances of colours (n, 2), and log likelihoods."""
    xx, xy, yy = (own + added for own, added in zip(model.covariance, noise, strict=True))
    determinant = xx * yy - xy * xy
    dx, dy = place[:, 0] - model.mean[0], place[:, 1] - model.mean[1]
    distance = (yy * dx * dx - 2.0 * xy * dx * dy + xx * dy * dy) / determinant
    return distance, -0.5 * (distance + np.log(determinant))
