"""A rival: a second hypothesis beside the tracked pose, until one of them is clearly beaten.

Slip and window searches find a pose at which one scan fits better. One scan may be wrong: people
stand round the robot, or the map lacks what it sees. So the pose found is followed by a belief of
its own, and the scans from then on decide between the two by a sequential probability ratio test
(Wald, "Sequential tests of statistical hypotheses", 1945).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from localization.filter import Belief, ParticleFilter
from localization.kld import SampleLimits
from localization.matching import Matching
from localization.settings import MotionNoise
from maps.pose import Pose, wrap_angle

BEATEN = 3.0  # log of the odds, 20 to 1, at which one of the two is beaten
MIN_SCANS = 3.0  # scans, weighted by their information, before the tracked pose may be beaten
MIN_TRAVEL = 0.5  # m or rad; likewise
INDEPENDENT_BEAMS = 12.0  # that a scan counts as in the odds
SAME_XY = 0.3  # m; poses nearer to each other are one hypothesis
SAME_THETA = 0.2  # rad; likewise
_LIMITS = SampleLimits(300, 1000)


class Rival:
    """A belief beside the tracked one, with the odds of the tracked pose against it."""

    def __init__(
        self,
        belief: Belief,
        pose: Pose,
        motion: MotionNoise,
        matching: Matching,
        rng: np.random.Generator,
    ) -> None:
        """Follow ``belief``; pose: its best one (map_from_base)."""
        self._filter = ParticleFilter(motion, matching.field, rng)
        self._filter.belief = belief
        self._filter.resample(_LIMITS)
        self._matching = matching
        self.pose = pose
        self.odds = 0.0
        """Log of the odds of the tracked pose against this one."""
        self._scans = self._travel = 0.0

    @property
    def belief(self) -> Belief:
        """The rival's particles."""
        return self._filter.belief

    @property
    def share(self) -> float:
        """Probability of the tracked pose against the rival, 0..1."""
        return 1.0 / (1.0 + math.exp(-self.odds))

    @property
    def wins(self) -> bool:
        """Whether the tracked pose is clearly beaten, over several scans and some travel."""
        lasted = self._scans >= MIN_SCANS and self._travel >= MIN_TRAVEL
        return lasted and self.odds <= -BEATEN

    @property
    def loses(self) -> bool:
        """Whether the rival is clearly beaten."""
        return self.odds >= BEATEN

    def follow(self, increment: Pose) -> None:
        """Move by a step of the odometry (base_then_from_base_now)."""
        self._filter.predict(increment)
        self._travel += max(math.hypot(increment.x, increment.y), abs(increment.theta))

    def weigh(self, points: NDArray[np.float64], information: float) -> None:
        """Weight the rival's belief by a scan, end points (m, 2), m, base_link."""
        self._filter.weigh(points, information * INDEPENDENT_BEAMS, through_walls=True)
        self.pose = self._matching.best_hypothesis(self._filter.belief, points).pose

    def compare(self, tracked: Pose, points: NDArray[np.float64], information: float) -> None:
        """Count one scan for the tracked pose or the rival."""
        gain = self._matching.check.log_odds(tracked, self.pose, points)
        gain *= INDEPENDENT_BEAMS * information
        self.odds = min(max(self.odds + gain, -2.0 * BEATEN), 2.0 * BEATEN)
        self._scans += information
        self._filter.resample(_LIMITS)


def is_same(pose: Pose, other: Pose) -> bool:
    """Whether two poses (map_from_base) are one hypothesis."""
    apart = math.hypot(pose.x - other.x, pose.y - other.y)
    return apart < SAME_XY and abs(wrap_angle(pose.theta - other.theta)) < SAME_THETA
