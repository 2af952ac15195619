"""A search of the whole map: beside the tracked pose, or at an unknown start."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from localization.alternative_hypothesis import AlternativeSearch
from localization.filter import Belief, ParticleFilter
from localization.global_search import GlobalSearch
from localization.health import LOCALIZED_SHARE, Evidence, Health, HealthMonitor
from localization.kld import SampleLimits
from localization.matching import Hypothesis, Matching
from localization.settings import MotionNoise
from maps.pose import Pose

KEPT_PARTICLES = 1000  # of the old belief, when a search starts again


class MapSearch:
    """Particles all over the map, until one place alone explains the scans since the start."""

    def __init__(
        self,
        floor: GlobalSearch,
        limits: SampleLimits,
        matching: Matching,
        motion: MotionNoise,
        rng: np.random.Generator,
    ) -> None:
        """Start with a fresh sample; raises MapError on a map without free floor."""
        self._floor = floor
        self._limits = limits
        self._matching = matching
        self._rng = rng
        self._filter = ParticleFilter(motion, matching.field, rng)
        self._alternatives = AlternativeSearch(motion, limits, matching, floor, rng)
        self._monitor = HealthMonitor(Health.LOST)
        self._fresh = True
        self._kept: Belief | None = None
        self.hypothesis: Hypothesis | None = None
        """The best one after the latest scan; None before the first."""
        self._filter.restart(floor.sample(rng))

    @property
    def belief(self) -> Belief:
        """The present particles."""
        return self._filter.belief

    @property
    def health(self) -> Health:
        """Health of the best hypothesis; localized: found."""
        return self._monitor.health

    def include(self, belief: Belief) -> None:
        """Search among the particles of a belief as well, half of the weight, from the start."""
        self._kept = belief

    def start_again(self) -> None:
        """Sample the whole map once more at the next scan; some of the old particles are kept."""
        self._kept = self._filter.drawn(KEPT_PARTICLES)
        self._filter.restart(self._floor.sample(self._rng))
        self._alternatives.forget()
        self._fresh = True

    def update(
        self, increment: Pose | None, points: NDArray[np.float64], information: float
    ) -> None:
        """Take in a scan, end points (m, 2), m, base_link, of an information weight, 0 to 1.

        increment: base_then_from_base_now since the last one; None at the first.
        """
        # 1. Predict and weight; a fresh sample is of this scan's time.
        fresh = self._fresh
        if fresh:
            self._alternatives.remember(None, points)
            self._floor.weigh_first(self._filter, points, self._limits)
            if self._kept is not None:
                self._filter.belief = self._kept.mixed_with(self._filter.belief)
        else:
            assert increment is not None
            self._filter.predict(increment)
            self._alternatives.remember(increment, points)
            self._floor.weigh(self._filter, points, information)
        self._fresh, self._kept = False, None
        # 2. Take the best place, and check it against the others.
        before = self.hypothesis
        self.hypothesis = self._matching.best_hypothesis(self._filter.belief, points)
        evidence = self._evidence(before, increment, points, information)
        found = self._monitor.preview(evidence) is Health.LOCALIZED
        judged = self._contested(evidence) if found else evidence
        if judged is not None:
            self._monitor.update(judged)
        if not found and not fresh and self._monitor.promising:
            self._alternatives.prepare(self.hypothesis.pose)
        # 3. Resample for the next scan.
        self._filter.resample(self._limits)

    def odds_against(self, pose: Pose) -> float:
        """Return the log-likelihood ratio of the kept scans, the best place over another pose."""
        assert self.hypothesis is not None
        return self._alternatives.odds(self.hypothesis.pose, pose)

    @property
    def stops(self) -> int:
        """Number of scans kept, a step apart each."""
        return self._alternatives.stops

    def _evidence(
        self,
        before: Hypothesis | None,
        increment: Pose | None,
        points: NDArray[np.float64],
        information: float,
    ) -> Evidence:
        assert self.hypothesis is not None
        pose, cluster = self.hypothesis.pose, self.hypothesis.cluster
        carried = pose
        if before is not None and increment is not None:
            carried = before.pose.compose(increment)
        jump = carried.between(pose)
        return Evidence(
            fit=self.hypothesis.fit,
            spread=cluster.spread,
            share=cluster.share,
            wall_crossing=self._matching.check.wall_crossing(pose, points),
            jump_xy=math.hypot(jump.x, jump.y),
            jump_theta=abs(jump.theta),
            information=information,
        )

    def _contested(self, evidence: Evidence) -> Evidence | None:
        """Return the evidence, with its share lowered if an alternative is as likely.

        The particles are then a mixture of both. None while that is not known.
        """
        assert self.hypothesis is not None
        alternative = self._alternatives.find(self.hypothesis.pose)
        if self._alternatives.pending:
            return None
        if alternative is None or alternative.share >= LOCALIZED_SHARE:
            return evidence
        self._filter.belief = self._filter.belief.mixed_with(alternative.belief, alternative.share)
        return replace(evidence, share=evidence.share * alternative.share)
