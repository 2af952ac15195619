"""The check before a global search ends: is there an alternative hypothesis as likely?

A search draws so few particles per area that there may be none near the true pose, but one near an
ambiguous place. So the scans since the search began are processed once more with fresh particles
everywhere but along the pose found; then both hypotheses are traced back by odometry, and the
likelihoods of the scans along them are compared. A few of the scans are processed again at each
new one, so that none takes long.
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
STOPS_AT_ONCE = 4  # scans processed again at each new one, at most
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


@dataclass(slots=True, eq=False)
class _Replay:
    """Fresh particles on their way through the scans kept, away from the pose found."""

    stops: list[Stop]
    avoided: list[Pose]
    """Pose found at each stop, map_from_base."""
    particles: ParticleFilter | None
    """None if none are left."""
    done: int = 0
    """Number of stops processed."""

    @property
    def finished(self) -> bool:
        return self.particles is None or self.done == len(self.stops)


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
        self._replay: _Replay | None = None

    @property
    def stops(self) -> int:
        """Number of scans kept."""
        return len(self._way)

    @property
    def pending(self) -> bool:
        """Whether ``find`` needs further calls, one a scan, to know."""
        return self._replay is not None

    def forget(self) -> None:
        """Drop all scans."""
        self._way.clear()
        self._since = Pose(0.0, 0.0, 0.0)
        self._replay = None

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
            if self._replay is not None:
                self._replay.stops.append(self._way[-1])
            self._since = Pose(0.0, 0.0, 0.0)

    def prepare(self, pose: Pose) -> None:
        """Process some of the scans for ``find`` with ``pose`` (map_from_base now), once a scan."""
        at_last_stop = pose.compose(self._since.inverse())
        if self._replay is None or not self._is_about(self._replay, at_last_stop):
            self._replay = self._new_replay(at_last_stop)
        self._advance(self._replay, at_last_stop)

    def find(self, pose: Pose) -> AlternativeHypothesis | None:
        """Return the best alternative to ``pose`` (map_from_base now).

        None if there is none, or while it is ``pending``.
        """
        self.prepare(pose)
        assert self._replay is not None
        if not self._replay.finished:
            return None
        alternatives, self._replay = self._replay.particles, None
        if alternatives is None:
            return None
        at_last_stop = pose.compose(self._since.inverse())
        others = heavy_clusters(alternatives.particles, alternatives.weights, _MAX_PLACES)
        best = max(self._log_likelihood(self._trace(other.mean)) for other in others)
        odds = self._log_likelihood(self._trace(at_last_stop)) - best
        alternatives.predict(self._since)
        return AlternativeHypothesis(alternatives.belief, odds)

    def odds(self, pose: Pose, other: Pose) -> float:
        """Return the log-likelihood ratio of the scans kept, ``pose`` over ``other``, both now."""
        back = self._since.inverse()
        one, two = (self._trace(each.compose(back)) for each in (pose, other))
        return self._log_likelihood(one) - self._log_likelihood(two)

    def _new_replay(self, at_last_stop: Pose) -> _Replay:
        particles = ParticleFilter(self.motion, self._field, self._rng)
        particles.restart(self._search.sample(self._rng))
        return _Replay(list(self._way), self._trace(at_last_stop), particles)

    def _is_about(self, replay: _Replay, at_last_stop: Pose) -> bool:
        """Whether a replay avoids a pose at the last stop, however far on the way it began."""
        pose = replay.avoided[-1]
        for stop in replay.stops[len(replay.avoided) :]:
            pose = pose.compose(stop.increment)
        return bool(near(np.array([pose]), at_last_stop)[0])

    def _advance(self, replay: _Replay, at_last_stop: Pose) -> None:
        """Process the next scans with particles that are not near the pose found.

        at_last_stop: that pose now, for scans kept since the replay began.
        """
        added = len(replay.stops) - len(replay.avoided)
        replay.avoided += [at_last_stop] * added
        for number in range(replay.done, min(replay.done + STOPS_AT_ONCE, len(replay.stops))):
            stop, particles = replay.stops[number], replay.particles
            if particles is None:
                return
            if number > 0:
                particles.resample(self._limits)
                particles.predict(stop.increment)
            if not particles.rule_out(near(particles.particles, replay.avoided[number])):
                replay.particles = None
                return
            if number > 0:
                self._search.weigh(particles, stop.points)
            else:
                self._search.weigh_first(particles, stop.points, self._limits)
            replay.done = number + 1

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
