"""The information weight of a scan, by the step since the last one.

Errors of scans from the same place are correlated; at full weight the covariance would become too
small. During a search of the whole map, which must not decide between two places by such errors,
their weight decays from scan to scan.
"""

from __future__ import annotations

import math

from maps.pose import Pose

FULL_STEP_XY = 0.2  # m of travel after which a scan counts in full
FULL_STEP_THETA = 0.2  # rad of turning likewise
STILL_INFORMATION = 0.3  # of a scan at the pose of the last one, whose errors it repeats
_STILL_DECAY = 0.8  # factor on that in a search, from one scan to the next at one place


class ScanInformation:
    """Weights of the latest scan, 0 to 1: while tracking, and in a search."""

    def __init__(self) -> None:
        self.tracking = self.searching = 1.0
        self._still_scans = 0

    def update(self, increment: Pose | None) -> None:
        """Take in a scan after a step (base_then_from_base_now); None: the first scan."""
        if increment is None:
            self.tracking = self.searching = 1.0
            return
        travel = math.hypot(increment.x, increment.y) / FULL_STEP_XY
        step = max(travel, abs(increment.theta) / FULL_STEP_THETA)
        self._still_scans = 0 if step > STILL_INFORMATION else self._still_scans + 1
        decayed = STILL_INFORMATION * _STILL_DECAY**self._still_scans
        self.tracking = min(1.0, max(STILL_INFORMATION, step))
        self.searching = min(1.0, max(decayed, step))
