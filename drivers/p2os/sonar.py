"""The sonar rings: last reading of every transducer and where it heard something."""

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
        """Latest ranges, (transducers,) m; inf where nothing was heard yet."""
        self._times = np.full(len(mounts), -np.inf)

    def update(self, t: float, readings: Iterable[tuple[int, float]]) -> None:
        """Take (transducer number, range in m) readings of time ``t``; unknown numbers are
        ignored."""
        for number, distance in readings:
            if 0 <= number < len(self.ranges):
                self.ranges[number] = distance
                self._times[number] = t

    def ages(self, t: float) -> NDArray[np.float64]:
        """Return the age of each reading at ``t``, (transducers,) s; inf where there is none."""
        return t - self._times

    def points(self, t: float, max_age: float) -> NDArray[np.float64]:
        """Return where transducers heard something lately, (n, 2) m in base_link.

        Readings older than ``max_age`` s or at the far value are left out.
        """
        echoes = self.echoes()
        return echoes[(self.ages(t) <= max_age) & np.isfinite(echoes[:, 0])]

    def echoes(self) -> NDArray[np.float64]:
        """Return where each transducer last heard something, (transducers, 2) m in base_link; nan
        where it heard nothing."""
        ranges = np.where(self.ranges < self._far, self.ranges, np.nan)
        return np.asarray(self._origins + ranges[:, None] * self._directions)
