"""How much farther scans show the robot travel than the wheels count.

A laser whose ranges are in another unit or too long, and wheels of another size than the model's,
both show a constant share; slip and people show in single samples.
"""

from __future__ import annotations

import math
from collections import deque
from statistics import median

import numpy as np
from numpy.typing import NDArray

from maps.pose import Pose

TOLERANCE = 0.07
"""Share that is not told: wheels are off by a few percent (Borenstein and Feng, UMBmark, 1996)."""
_SAMPLES = 15  # the median of which is judged
_LEAST = 0.25  # m of a sample's way
_CERTAIN = 0.05  # of the way: standard deviation along it, above which a sample does not count


class TravelScale:
    """Collects samples; ``off`` is the share by which scans show more way than wheels."""

    def __init__(self) -> None:
        self._shares: deque[float] = deque(maxlen=_SAMPLES)

    @property
    def off(self) -> float | None:
        """The share, negative for less way; None while it is tolerated, or too little is known."""
        if len(self._shares) < _SAMPLES:
            return None
        share = median(self._shares)
        return share if abs(share) > TOLERANCE else None

    def add(self, wheels: Pose, seen: Pose, information: NDArray[np.float64]) -> None:
        """Add a sample: motion counted, motion seen, and the (2, 2) information of its shift."""
        way = math.hypot(wheels.x, wheels.y)
        if way < _LEAST:
            return
        ahead = np.array((wheels.x, wheels.y)) / way
        certainty = float(ahead @ information @ ahead)
        if certainty * (_CERTAIN * way) ** 2 >= 1.0:
            self._shares.append(float(ahead @ (seen.x, seen.y)) / way - 1.0)
