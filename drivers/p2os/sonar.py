"""The sonar rings: latest range of every transducer, as points in base_link."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from drivers.p2os.model import RobotModel

FAR_MARGIN = 0.01  # m, covers the rounding of the far value to wire counts


class SonarRing:
    """Keeps the latest reading of each transducer with its age."""

    def __init__(self, model: RobotModel) -> None:
        mounts = model.sonar
        headings = np.radians([mount.heading_deg for mount in mounts])
        self._origins = np.array([(mount.x, mount.y) for mount in mounts])
        self._directions = np.column_stack((np.cos(headings), np.sin(headings)))
        self._far = model.sonar_far - FAR_MARGIN
        self.ranges: NDArray[np.float64] = np.full(len(mounts), np.inf)
        """Latest ranges, (transducers,) m; inf before the first reading."""
        self._times = np.full(len(mounts), -np.inf)

    def update(self, t: float, readings: Iterable[tuple[int, float]]) -> None:
        """Take readings (transducer number, range in m) of time ``t``; ignore unknown numbers."""
        for number, distance in readings:
            if 0 <= number < len(self.ranges):
                self.ranges[number] = distance
                self._times[number] = t

    def ages(self, t: float) -> NDArray[np.float64]:
        """Return the age of each reading at ``t``, (transducers,) s; inf before the first."""
        return t - self._times

    def points(self, t: float, max_age: float) -> NDArray[np.float64]:
        """Return the recent echoes as points (n, 2), m, in base_link.

        Readings older than ``max_age`` (s) or at the far value, which means no echo, are left out.
        """
        echoes = self.echoes()
        return np.asarray(echoes[(self.ages(t) <= max_age) & np.isfinite(echoes[:, 0])])

    def echoes(self) -> NDArray[np.float64]:
        """Return each transducer's last echo as points (transducers, 2), m, in base_link; nan for
        those without one."""
        ranges = np.where(self.ranges < self._far, self.ranges, np.nan)
        return np.asarray(self._origins + ranges[:, None] * self._directions)
