"""The check before a global search ends: is there an alternative hypothesis as likely?

A search draws so few particles per area that there may be none near the true pose, but one near an
ambiguous place. So the scans since the search began are processed once more with fresh particles
everywhere but along the pose found; then both hypotheses are traced back by odometry, and the
likelihoods of the scans along them are compared.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from localization.cluster import heavy_clusters, near
from localization.filter import Belief, ParticleFilter
from localization.global_search import (
    HIDDEN_LOG_LIKELIHOOD,
    INDEPENDENT_BEAMS,
    GlobalSearch,
)
from localization.kld import SampleLimits
from localization.matching import Matching
from localization.motion_model import step_covariance
from localization.settings import MotionNoise
from maps.pose import Pose

STOPS = 16  # scans kept
STOP_XY = 0.4  # m between two of them
STOP_THETA = 0.4  # rad; likewise
_MAX_PLACES = 8  # alternative clusters compared
_ODDS_LIMIT = 700.0  # exp() of more is infinite


@dataclass(frozen=True, slots=True, eq=False)
class Stop:
    """One scan kept since the search began."""

    increment: Pose
    """base_then_from_base_now since the stop before."""
    points: NDArray[np.float64]
    """(n, 2) end points, base_link, m."""


@dataclass(frozen=True, slots=True, eq=False)
class AlternativeHypothesis:
    """The best alternative to the pose found."""

    belief: Belief
    """Particles of the alternatives."""
    odds: float
    """Log of the likelihood ratio of the scans, pose found over alternative."""

    @property
    def share(self) -> float:
        """Probability of the pose found against the alternative, 0..1."""
        return 1.0 / (1.0 + math.exp(min(-self.odds, _ODDS_LIMIT)))


class AlternativeSearch:
    """Keeps the scans since a search began and finds the best alternative pose for them."""

    def __init__(
        self,
        motion: MotionNoise,
        limits: SampleLimits,
        matching: Matching,
        search: GlobalSearch,
        rng: np.random.Generator,
    ) -> None:
        self.motion = motion
        self._limits = limits
        self._field = matching.field
        self._refinement = matching.refinement
        self._search = search
        self._rng = rng
        self._way: deque[Stop] = deque(maxlen=STOPS)
        self._since = Pose(0.0, 0.0, 0.0)

    @property
    def stops(self) -> int:
        """Number of scans kept."""
        return len(self._way)

    def forget(self) -> None:
        """Drop all scans."""
        self._way.clear()
        self._since = Pose(0.0, 0.0, 0.0)

    def remember(self, increment: Pose | None, points: NDArray[np.float64]) -> None:
        """Keep a scan, (m, 2) end points, m, base_link, if far enough from the last one kept.

        increment: base_then_from_base_now since the last call; None at the first scan.
        """
        if increment is not None:
            self._since = self._since.compose(increment)
        apart = math.hypot(self._since.x, self._since.y) >= STOP_XY
        turned = abs(self._since.theta) >= STOP_THETA
        if apart or turned or not self._way:
            self._way.append(Stop(self._since, points))
            self._since = Pose(0.0, 0.0, 0.0)

    def find(self, pose: Pose) -> AlternativeHypothesis | None:
        """Return the best alternative to ``pose`` (map_from_base now); None if there is none."""
        at_last_stop = pose.compose(self._since.inverse())
        found = self._trace(at_last_stop)
        alternatives = self._replay(found)
        if alternatives is None:
            return None
        others = heavy_clusters(alternatives.particles, alternatives.weights, _MAX_PLACES)
        best = max(self._log_likelihood(self._trace(other.mean)) for other in others)
        odds = self._log_likelihood(found) - best
        alternatives.predict(self._since)
        return AlternativeHypothesis(alternatives.belief, odds)

    def odds(self, pose: Pose, other: Pose) -> float:
        """Return the log-likelihood ratio of the scans kept, ``pose`` over ``other``, both now."""
        back = self._since.inverse()
        one, two = (self._trace(each.compose(back)) for each in (pose, other))
        return self._log_likelihood(one) - self._log_likelihood(two)

    def _replay(self, avoided: list[Pose]) -> ParticleFilter | None:
        """Process the scans again without particles near the poses avoided, one per scan.

        None if no particles are left.
        """
        particles = ParticleFilter(self.motion, self._field, self._rng)
        particles.restart(self._search.sample(self._rng))
        for number, (stop, pose) in enumerate(zip(self._way, avoided, strict=True)):
            if number > 0:
                particles.resample(self._limits)
                particles.predict(stop.increment)
            if not particles.rule_out(near(particles.particles, pose)):
                return None
            if number > 0:
                self._search.weigh(particles, stop.points)
            else:
                self._search.weigh_first(particles, stop.points, self._limits)
        return particles

    def _trace(self, pose: Pose) -> list[Pose]:
        """Return the pose at each scan kept, given ``pose`` at the last one.

        Each step of the odometry is reversed and the pose refined by the scan.
        """
        stops, poses = list(self._way), []
        covariance = step_covariance(Pose(0.0, 0.0, 0.0), self.motion)
        for stop in reversed(stops):
            refined = self._refinement.refine(pose, covariance, stop.points)
            pose = pose if refined is None else refined.pose
            poses.append(pose)
            pose = pose.compose(stop.increment.inverse())
            covariance = step_covariance(stop.increment, self.motion)
        return poses[::-1]

    def _log_likelihood(self, poses: list[Pose]) -> float:
        """Return the log-likelihood of the scans kept, one from each of poses.

        Where people occlude the map a scan fits nowhere, by chance better or worse: each scan
        counts at least ``HIDDEN_LOG_LIKELIHOOD`` a beam.
        """
        floor = INDEPENDENT_BEAMS * HIDDEN_LOG_LIKELIHOOD
        return sum(
            max(floor, self._log_likelihood_at(pose, stop.points))
            for stop, pose in zip(self._way, poses, strict=True)
        )

    def _log_likelihood_at(self, pose: Pose, points: NDArray[np.float64]) -> float:
        return float(self._field.log_weights(np.array([pose]), points, INDEPENDENT_BEAMS)[0])
