"""Likelihood field: how well the end points of a scan fit the map, for many poses at once.

Thrun, Burgard, Fox, "Probabilistic Robotics", section 6.4 (likelihood_field_range_finder_model).
The field is an image of a beam's log-likelihood by its end point; a scan seen from n particles is
one matrix product and one gather from it.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from localization.settings import SensorSettings
from maps.occupancy_map import OccupancyMap

_CHUNK = 2000  # particles gathered at once: what fits the cache (cv2.remap takes 32767 at most)


class LikelihoodField:
    """Log-likelihoods of end points, looked up in the nearest cell."""

    def __init__(self, settings: SensorSettings, occupancy: OccupancyMap) -> None:
        self._beams = settings.beams
        self._origin = occupancy.origin
        self._resolution = occupancy.resolution
        fit = np.exp(-0.5 * (occupancy.distance_field() / np.float32(settings.sigma)) ** 2)
        share = settings.random_share
        self._log_image = np.log((1.0 - share) * fit + share).astype(np.float32)
        self._log_outside = float(np.log(share))

    def log_weights(
        self,
        particles: NDArray[np.float64],
        points: NDArray[np.float64],
        independent_beams: float,
        beams: int | None = None,
    ) -> NDArray[np.float64]:
        """Return (n,) log-likelihoods of the scan for particles (n, 3) (map_from_base).

        points: (m, 2) end points in base_link, m. The product over the beams is tempered to what
        ``independent_beams`` of them would tell: neighbouring beams hit the same surface and err
        together, so that a plain product would be overconfident. beams: how many are looked at, if
        not as many as the settings say.
        """
        points = spread_evenly(points, beams or self._beams)
        if len(points) == 0:
            return np.zeros(len(particles))
        exponent = min(1.0, independent_beams / len(points))
        weight = np.full(len(points), exponent, dtype=np.float32)
        chunks = [
            weight @ self._gather(particles[start : start + _CHUNK], points)
            for start in range(0, len(particles), _CHUNK)
        ]
        return np.concatenate(chunks).astype(np.float64)

    def _gather(
        self, particles: NDArray[np.float64], points: NDArray[np.float64]
    ) -> NDArray[np.float32]:
        """Return (m, n) each beam's log-likelihood for each particle.

        A beam's ends lie close together for all particles of a cloud: in this order the look-ups
        stay in the cache.
        """
        columns, rows = self._pixels(particles, points)
        looked_up = cv2.remap(
            self._log_image,
            columns,
            rows,
            cv2.INTER_NEAREST,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=self._log_outside,
        )
        return np.asarray(looked_up, dtype=np.float32)

    def _pixels(
        self, poses: NDArray[np.float64], points: NDArray[np.float64]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return (m, n) columns and (m, n) rows of points (m, 2) seen from poses (n, 3).

        In pixels; (0, 0) is the centre of the lower-left cell.
        """
        count = len(poses)
        heading = poses[:, 2].astype(np.float32)
        scale = np.float32(1.0 / self._resolution)
        cosine, sine = np.cos(heading) * scale, np.sin(heading) * scale
        rigid = np.empty((2, 3, count), dtype=np.float32)
        rigid[0, 0], rigid[0, 1] = cosine, -sine
        rigid[1, 0], rigid[1, 1] = sine, cosine
        rigid[0, 2] = (poses[:, 0] - self._origin.x) / self._resolution - 0.5
        rigid[1, 2] = (poses[:, 1] - self._origin.y) / self._resolution - 0.5
        homogeneous = np.ones((len(points), 3), dtype=np.float32)
        homogeneous[:, :2] = points
        return homogeneous @ rigid[0], homogeneous @ rigid[1]


def spread_evenly(points: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Return at most ``count`` of points (m, 2), evenly spread over their order."""
    if len(points) <= count:
        return points
    return points[np.arange(count) * len(points) // count]
