"""Detection of wheel slip: search for the pose back along the last step of the odometry.

In a bare corridor the particles do not reveal a slip: most beams end on its sides, which fit
equally well all along it, and the few other beams have less weight than the odometry. Along this
one line a scan can be given a much larger information weight.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from localization.matching import Matching
from localization.refinement import Refined
from maps.pose import Pose

MAX_SLIP = 0.5  # maximum share of a counted translation that is lost
CANDIDATES = 10  # poses tried, spread evenly up to it
BEAMS = 180  # of a scan, spread evenly over it, at most: few of them are informative
INDEPENDENT_BEAMS = 60.0  # that they count as together
MIN_GAIN = 2.0  # of log-likelihood, for a pose to be preferred
CERTAIN_ODDS = 4.6  # log of 100 to 1, for a pose that people cannot explain
MIN_SHIFT = 0.1  # m; a smaller shift is left to the filter


@dataclass(frozen=True, slots=True, eq=False)
class Slipped:
    """A pose back along the last step at which the scan fits better."""

    refined: Refined
    certain: bool
    """Whether it does by the beams alone that people cannot explain."""


class SlipSearch:
    """Compares a pose with those that result from slip by some share of the last step."""

    def __init__(self, matching: Matching, *, min_gain: float = MIN_GAIN) -> None:
        """Prepare for one map. min_gain: of log-likelihood, for a pose to be preferred."""
        self._min_gain = min_gain
        self._field = matching.field
        self._refinement = matching.refinement
        self._check = matching.check
        self._lost = np.arange(1, CANDIDATES + 1) / CANDIDATES * MAX_SLIP

    def find(self, pose: Pose, increment: Pose, points: NDArray[np.float64]) -> Slipped | None:
        """Return the pose behind ``pose`` (map_from_base) at which the scan fits clearly better.

        increment: the odometry's last step (base_then_from_base_now). points (m, 2): base_link, m.
        None if there is none, or if the step is too short.
        """
        travel = math.hypot(increment.x, increment.y)
        if travel * MAX_SLIP < MIN_SHIFT:
            return None
        behind = self._behind(pose, increment, travel)
        fits = self._fits(np.vstack((np.array(pose), behind)), points)
        best = int(fits[1:].argmax())
        if fits[1 + best] < fits[0]:
            return None
        spacing = travel * MAX_SLIP / CANDIDATES
        place = Pose(*behind[best].tolist())
        refined = self._refinement.refine(place, np.diag((spacing**2, spacing**2, 1e-3)), points)
        if refined is None:
            return None
        shift = math.hypot(refined.pose.x - pose.x, refined.pose.y - pose.y)
        gain = float(self._fits(np.array([refined.pose]), points)[0] - fits[0])
        if shift < MIN_SHIFT or gain < self._min_gain:
            return None
        # A person explains a reading that is too short, and not one that is too long.
        others = points[~self._check.short(pose, points)]
        places = np.array((pose, refined.pose))
        before, after = self._fits(places, others).tolist()
        if after - before < self._min_gain:
            return Slipped(refined, certain=False)
        odds = INDEPENDENT_BEAMS * self._check.log_odds(refined.pose, pose, points)
        return Slipped(refined, certain=odds >= CERTAIN_ODDS)

    def _behind(self, pose: Pose, increment: Pose, travel: float) -> NDArray[np.float64]:
        """Return (n, 3) poses back along a step of travel, m, by each share lost; same heading."""
        heading = pose.theta - increment.theta + math.atan2(increment.y, increment.x)
        back = self._lost * travel
        places = np.empty((len(back), 3))
        places[:, 0] = pose.x - back * math.cos(heading)
        places[:, 1] = pose.y - back * math.sin(heading)
        places[:, 2] = pose.theta
        return places

    def _fits(self, poses: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
        return self._field.log_weights(poses, points, INDEPENDENT_BEAMS, BEAMS)
