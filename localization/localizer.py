"""The localizer: pose estimate with covariance and health from odometry and scans.

Three beliefs at most live side by side. The tracked one gives the estimate. A rival is a pose at
which one scan fits better; the following scans decide between the two. A search of the whole map
runs beside them while the tracked pose is in doubt. Neither replaces the tracked pose unless it
explains the scans clearly better.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from localization.alternative_hypothesis import AlternativeSearch
from localization.cluster import best_cluster
from localization.estimate import Estimate
from localization.filter import Belief, ParticleFilter
from localization.global_search import GlobalSearch
from localization.health import (
    LOCALIZED_ABOVE,
    LOCALIZED_SHARE,
    LOCALIZED_WALL_CROSSING,
    UNSURE_BELOW,
    UNSURE_WALL_CROSSING,
    Evidence,
    Health,
    HealthMonitor,
)
from localization.kld import SampleLimits
from localization.map_search import MapSearch
from localization.matching import Hypothesis, Matching
from localization.refinement import Refined
from localization.resampling import effective_sample_size
from localization.rival import Rival, is_same
from localization.scan_check import Fit
from localization.scan_information import ScanInformation
from localization.settings import LocalizationSettings, MotionNoise
from localization.slip_search import SlipSearch
from maps.occupancy_map import OccupancyMap
from maps.pose import Pose

MIN_SIGMA_XY = 0.0144  # m; lower bound of an estimate's: quantization by a cell of 0.05 m
MIN_SIGMA_THETA = 0.005  # rad; likewise: error of the laser's mount
INDEPENDENT_BEAMS = 12.0  # that the beams of one scan count as together
DOUBTED_BEAMS = 3  # times as many are used while not localized: in a crowd few of them tell


class Window(NamedTuple):
    """A window of poses round the estimate."""

    reach: tuple[float, float, float]
    """m, m, rad either way."""
    samples: int
    least_fit: float
    """Of a pose that is preferred."""


# The search in a window round the estimate, when a scan does not fit at the predicted pose.
WINDOW_BELOW = 0.8  # fit of a scan, without dynamic beams, that starts it
WINDOW_GAIN = 0.1  # by which it must fit better
WINDOW_TRIED = 6  # of the best samples, hypotheses apart
EMPTY_ABOVE = 0.9  # fit of a pose at which there are no people in the scan
WINDOW_ABOVE = 0.75  # fit of a pose that is preferred
WINDOW = Window((1.0, 1.0, 0.6), 3000, WINDOW_ABOVE)
TURNED_WINDOWS = (
    Window((0.4, 0.4, math.pi), 3000, WINDOW_ABOVE),
    Window((1.0, 1.0, math.pi), 12000, EMPTY_ABOVE),  # among so many poses some fit by chance
)
"""Of a robot that its wheels did not see turning."""
REFUTED_ABOVE = 0.15
"""Share of the beams behind walls, as of ``Fit.through``, above which one scan refutes a pose. At
true poses, with people before 60 % of the beams, it was up to 0.03 in 95 % of the scans, and never
above this.
"""

# The search over the whole map.
MAX_SEARCH_PARTICLES = 20_000  # during a search, after the first scan
DOUBTED = 4.0  # scans with an unsure pose until a search starts
REPEAT = 15.0  # scans until it starts again
FOUND_ODDS = 4.6  # log of 100 to 1, for a place found, against the tracked pose
FOUND_STOPS = 3  # scans, a step apart each, that it takes
_WINDOW_STEP = 0.2  # of a window's reach: spacing of samples, for the refinement's prior


class Localizer:
    """Monte Carlo localization of the base in a known map.

    ``estimate`` is None until the first ``update`` after ``start_at`` or ``start_anywhere``.
    """

    def __init__(
        self,
        settings: LocalizationSettings,
        occupancy: OccupancyMap,
        rng: np.random.Generator,
    ) -> None:
        self._rng = rng
        self._settings = settings
        self._motion = settings.motion.over(MotionNoise())
        self._matching = Matching(occupancy, settings.beams)
        self._filter = ParticleFilter(self._motion, self._matching.field, rng)
        self._slips = SlipSearch(self._matching)
        self._floor = GlobalSearch(occupancy)
        self._limits = SampleLimits(
            settings.min_particles, settings.max_particles, settings.particles
        )
        # A number fixed for tracking would be too small for a search.
        self._search_limits = SampleLimits(settings.min_particles, MAX_SEARCH_PARTICLES)
        self._alternatives = self._new_alternatives()
        self._min_covariance = np.diag(np.square((MIN_SIGMA_XY, MIN_SIGMA_XY, MIN_SIGMA_THETA)))
        self._forget()
        self._tracking = False

    def _new_alternatives(self) -> AlternativeSearch:
        return AlternativeSearch(
            self._motion, self._search_limits, self._matching, self._floor, self._rng
        )

    def _forget(self) -> None:
        """Return to the state before the first scan."""
        self._monitor = HealthMonitor()
        self._rival: Rival | None = None
        self._search: MapSearch | None = None
        # Whether the pose is checked against alternative hypotheses before it becomes localized.
        self._contestable = False
        # Whether the latest scan refutes the tracked pose, whoever stands round the robot.
        self._refuted = False
        self._information = ScanInformation()
        self._last_odometry: Pose | None = None
        self._search_due = 0.0  # 0 to 1; at 1 a search of the whole map starts
        self.estimate: Estimate | None = None

    def use_noise(self, noise: MotionNoise) -> None:
        """Take the noise of the robot's odometry, where the settings leave it open."""
        self._motion = self._settings.motion.over(noise)
        self._filter.motion = self._alternatives.motion = self._motion

    @property
    def particles(self) -> NDArray[np.float64]:
        """Present particles (n, 3), map_from_base."""
        return self._belief.particles

    @property
    def weights(self) -> NDArray[np.float64]:
        """Present weights (n,), summing to 1."""
        return self._belief.weights

    @property
    def _belief(self) -> Belief:
        if self._tracking or self._search is None:
            return self._filter.belief
        return self._search.belief

    def start_at(self, pose: Pose, sigma_xy: float, sigma_theta: float) -> None:
        """Start at a pose (map_from_base), with standard deviations in m and rad."""
        limits = self._limits
        count = limits.fixed if limits.fixed is not None else limits.maximum
        scatter = self._rng.standard_normal((count, 3)) * (sigma_xy, sigma_xy, sigma_theta)
        self._forget()
        self._filter.restart(np.array(pose) + scatter)
        self._tracking = True

    def start_anywhere(self) -> None:
        """Start a global search, with particles all over the map's free floor.

        Raises MapError on a map without free floor.
        """
        self._forget()
        self._search = self._new_search()
        self._tracking = False

    def _new_search(self) -> MapSearch:
        return MapSearch(self._floor, self._search_limits, self._matching, self._motion, self._rng)

    def update(
        self,
        t: float,
        odometry: Pose,
        points: NDArray[np.float64],
        ignore: NDArray[np.bool_] | None = None,
    ) -> Estimate:
        """Update by a scan and return the new estimate.

        t: when the scan was measured. odometry: odom_from_base then. points: (n, 2) end points
        of the beams that returned, m, base_link at that time, in the order of their bearing.
        ignore: (n,) the beams known to end on people or teammates. Raises RuntimeError before a
        start.
        """
        if not self._tracking and self._search is None:
            raise RuntimeError("the localizer was told no start: call start_at or start_anywhere")
        if ignore is not None:
            points = points[~ignore]
        increment = None if self._last_odometry is None else self._last_odometry.between(odometry)
        self._last_odometry = odometry
        self._information.update(increment)
        # 1. Follow the tracked pose, and say how healthy it is.
        if self._tracking:
            self.estimate = self._track(t, odometry, increment, points)
        # 2. While it is in doubt, search the whole map beside it.
        if self._search is not None:
            self._search.update(increment, points, self._information.searching)
            if not self._tracking or self._is_beaten(self._search):
                self.estimate = self._found(t, odometry, self._search)
        assert self.estimate is not None
        return self.estimate

    def disown(self, estimate: Estimate) -> Estimate:
        """Return the latest estimate as a lost one: other evidence shows it to be wrong."""
        self.estimate = replace(estimate, health=Health.LOST)
        return self.estimate

    # --- the tracked pose ------------------------------------------------------------------------

    def _track(
        self, t: float, odometry: Pose, increment: Pose | None, points: NDArray[np.float64]
    ) -> Estimate:
        """Return the estimate by the tracked belief after one scan."""
        # 1. Predict by the odometry since the last scan.
        if increment is not None:
            self._filter.predict(increment)
            if self._rival is not None:
                self._rival.follow(increment)
        points = self._without_occluder(odometry, points)
        if self._contestable:
            self._alternatives.remember(increment, points)
        # 2. Weight the particles by the scan, and take the best cluster, refined by it.
        information = self._information.tracking
        localized = self._monitor.health is Health.LOCALIZED
        beams = self._settings.beams * (1 if localized else DOUBTED_BEAMS)
        self._filter.weigh(
            points, information * INDEPENDENT_BEAMS, beams=beams, through_walls=not localized
        )
        hypothesis = self._matching.best_hypothesis(self._filter.belief, points)
        # 3. Compare it with its rival; look for one back along the step, and in a window.
        hypothesis = self._against_rival(hypothesis, points, information)
        hypothesis = self._search_slip(hypothesis, increment, points)
        hypothesis = self._search_window(hypothesis, points, information)
        # 4. Determine health and covariance.
        estimate = self._make_estimate(t, odometry, points, hypothesis, information)
        # 5. Resample for the next scan.
        self._filter.resample(self._limits)
        return estimate

    def _without_occluder(self, odometry: Pose, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return points (n, 2) without those on a large unmapped object close to the robot.

        All points while lost: the pose is not good enough to detect one.
        """
        if self.estimate is None or self.estimate.health is Health.LOST:
            return points
        hiding = self._matching.check.hiding(self.estimate.pose_at(odometry), points)
        return points if hiding is None else points[~hiding]

    def _against_rival(
        self, hypothesis: Hypothesis, points: NDArray[np.float64], information: float
    ) -> Hypothesis:
        """Return the better of tracked pose and rival, once one of them is clearly beaten."""
        rival = self._rival
        if rival is None:
            return hypothesis
        rival.weigh(points, information)
        rival.compare(hypothesis.pose, points, information)
        if rival.loses or is_same(rival.pose, hypothesis.pose):
            self._rival = None
        elif rival.wins:
            self._rival = None
            self._filter.belief = rival.belief
            return self._matching.best_hypothesis(rival.belief, points)
        return hypothesis

    def _propose(
        self,
        hypothesis: Hypothesis,
        other: Hypothesis,
        belief: Belief,
        points: NDArray[np.float64],
        *,
        at_once: bool,
    ) -> Hypothesis:
        """Return the hypothesis to go on with, and keep the other one of the two as its rival.

        other: at which the scan fits better, with its belief. at_once: whether this scan refutes
        the first.
        """
        if not at_once:
            if self._rival is None or self._fits_better(other, self._rival, points):
                self._rival = self._new_rival(belief, other.pose)
            return hypothesis
        self._rival = self._new_rival(self._filter.belief, hypothesis.pose)
        self._filter.belief = belief
        return other

    def _fits_better(self, other: Hypothesis, rival: Rival, points: NDArray[np.float64]) -> bool:
        """Whether a scan fits a hypothesis clearly better than the present rival."""
        fit = self._matching.check.fit(rival.pose, points)
        return (
            other.fit is not None and fit is not None and other.fit.whole > fit.whole + WINDOW_GAIN
        )

    def _new_rival(self, belief: Belief, pose: Pose) -> Rival:
        return Rival(belief, pose, self._motion, self._matching, self._rng)

    def _search_slip(
        self, hypothesis: Hypothesis, increment: Pose | None, points: NDArray[np.float64]
    ) -> Hypothesis:
        """Return the hypothesis moved back along the last step if the scan fits better there."""
        if increment is None:
            return hypothesis
        slipped = self._slips.find(hypothesis.pose, increment, points)
        if slipped is None:
            return hypothesis
        pose, belief = slipped.refined.pose, self._filter.belief
        back = (pose.x - hypothesis.pose.x, pose.y - hypothesis.pose.y, 0.0)
        moved = replace(belief, particles=belief.particles + back)
        cluster = replace(hypothesis.cluster, mean=pose)
        fit = self._matching.check.fit(pose, points)
        other = Hypothesis(cluster, slipped.refined, pose, fit)
        # At a wrong pose in a crowd another a step back is often better, and as wrong.
        at_once = slipped.certain and fit is not None and fit.beside >= LOCALIZED_ABOVE
        return self._propose(hypothesis, other, moved, points, at_once=at_once)

    def _search_window(
        self, hypothesis: Hypothesis, points: NDArray[np.float64], information: float
    ) -> Hypothesis:
        """Return the best hypothesis in a window round a pose that the scan does not fit.

        Returns the given one if the scan fits it, or fits nowhere else clearly better.
        """
        if hypothesis.fit is None or hypothesis.fit.fit_without_dynamic >= WINDOW_BELOW:
            return hypothesis
        crossing = self._matching.check.wall_crossing(hypothesis.pose, points)
        refuted = hypothesis.fit.through > REFUTED_ABOVE or crossing > UNSURE_WALL_CROSSING
        found = self._in_window(WINDOW, hypothesis, points, information)
        for window in TURNED_WINDOWS if refuted else ():  # wheels may miss a turn of any size
            if found is None:
                found = self._in_window(window, hypothesis, points, information)
        if found is None:
            return hypothesis
        other, belief = found
        # Nor is anybody there where nearly the whole scan fits, and it does not at the pose.
        assert other.fit is not None
        empty = other.fit.whole >= EMPTY_ABOVE
        refuted = refuted or (empty and hypothesis.fit.fit_without_dynamic < UNSURE_BELOW)
        if refuted:
            odds = self._matching.check.log_odds(other.pose, hypothesis.pose, points)
            refuted = INDEPENDENT_BEAMS * odds >= FOUND_ODDS
        if refuted:
            self._restart_alternatives(points)
        return self._propose(hypothesis, other, belief, points, at_once=refuted)

    def _in_window(
        self,
        window: Window,
        hypothesis: Hypothesis,
        points: NDArray[np.float64],
        information: float,
    ) -> tuple[Hypothesis, Belief] | None:
        """Return the best hypothesis in a window round the given one, with its belief.

        None if the scan fits nowhere clearly better.
        """
        assert hypothesis.fit is not None
        spread = np.array(window.reach)
        offsets = self._rng.uniform(-1.0, 1.0, (window.samples, 3)) * spread
        inside = ParticleFilter(self._motion, self._matching.field, self._rng)
        inside.restart(np.array(hypothesis.cluster.mean) + offsets)
        inside.weigh(points, information * INDEPENDENT_BEAMS)
        needed = max(window.least_fit, hypothesis.fit.whole + WINDOW_GAIN)
        covariance = np.diag(np.square(_WINDOW_STEP * np.minimum(spread, WINDOW.reach)))
        best: tuple[Refined, Fit] | None = None
        for start in _apart(inside.belief, WINDOW_TRIED):
            refined = self._matching.refinement.refine(start, covariance, points)
            fit = None if refined is None else self._matching.check.fit(refined.pose, points)
            if refined is None or fit is None or fit.whole < needed:
                continue
            # At a wrong pose beams cross mapped walls.
            crossing = self._matching.check.wall_crossing(refined.pose, points)
            if crossing <= LOCALIZED_WALL_CROSSING:
                needed, best = fit.whole, (refined, fit)
        if best is None:
            return None
        refined, fit = best
        cluster = best_cluster(inside.particles, inside.weights)
        return Hypothesis(cluster, refined, refined.pose, fit, relocated=True), inside.belief

    def _restart_alternatives(self, points: NDArray[np.float64]) -> None:
        """Search alternatives from this scan on, as odometry does not lead to the pose."""
        self._contestable = True
        self._alternatives.forget()
        self._alternatives.remember(None, points)

    def _make_estimate(
        self,
        t: float,
        odometry: Pose,
        points: NDArray[np.float64],
        hypothesis: Hypothesis,
        information: float,
    ) -> Estimate:
        """Return the estimate of a hypothesis, and update health and search state by it."""
        cluster, pose = hypothesis.cluster, hypothesis.pose
        last = self.estimate
        jump = Pose(0.0, 0.0, 0.0) if last is None else last.pose_at(odometry).between(pose)
        before = self._monitor.health
        # While localized with a good fit, the wall-crossing share is not needed.
        fit = 0.0 if hypothesis.fit is None else hypothesis.fit.whole
        good = before is Health.LOCALIZED and fit >= WINDOW_ABOVE
        evidence = Evidence(
            fit=hypothesis.fit,
            spread=cluster.spread,
            share=cluster.share * (1.0 if self._rival is None else self._rival.share),
            relocated=hypothesis.relocated,
            wall_crossing=0.0 if good else self._matching.check.wall_crossing(pose, points),
            jump_xy=math.hypot(jump.x, jump.y),
            jump_theta=abs(jump.theta),
            information=information,
        )
        found = self._contestable and self._monitor.preview(evidence) is Health.LOCALIZED
        judged = self._contested(evidence, pose) if found else evidence
        health = self._monitor.health if judged is None else self._monitor.update(judged)
        if self._contestable and not found and self._monitor.promising:
            self._alternatives.prepare(pose)
        self._refuted = hypothesis.fit is not None and hypothesis.fit.through > REFUTED_ABOVE
        self._update_search_due(before, health, hypothesis.fit, information)
        return self._estimate_of(t, odometry, hypothesis, health)

    def _estimate_of(
        self, t: float, odometry: Pose, hypothesis: Hypothesis, health: Health
    ) -> Estimate:
        return Estimate(
            t=t,
            pose=hypothesis.pose,
            odometry=odometry,
            covariance=hypothesis.covariance + self._min_covariance,
            health=health,
            particle_count=len(self.weights),
            effective_sample_size=effective_sample_size(self.weights),
            likelihood=0.0 if hypothesis.fit is None else hypothesis.fit.whole,
            refined=hypothesis.refined is not None,
        )

    # --- the search of the whole map -------------------------------------------------------------

    def _contested(self, evidence: Evidence, pose: Pose) -> Evidence | None:
        """Return the evidence, with its share lowered if an alternative is clearly more likely.

        The whole map is then searched beside the pose, beginning with the alternative. None while
        that is not known.
        """
        alternative = self._alternatives.find(pose)
        if self._alternatives.pending:
            return None
        if alternative is None or alternative.share >= 1.0 - LOCALIZED_SHARE:
            return evidence
        if self._search is None:
            self._search = self._new_search()
            self._search.include(alternative.belief)
        return replace(evidence, share=evidence.share * alternative.share)

    def _update_search_due(
        self, before: Health, health: Health, fit: Fit | None, information: float
    ) -> None:
        """Start a search of the whole map when lost, and again after more scans in doubt."""
        if health is Health.LOCALIZED:
            self._search_due, self._search, self._contestable = 0.0, None, False
            return
        if health is Health.LOST and before is not Health.LOST and self._search is None:
            self._search_due = 1.0
        elif fit is not None:
            scans = REPEAT if self._search is not None else DOUBTED
            self._search_due += information / scans
        if self._search_due < 1.0 or not self._floor.possible:
            return
        self._search_due = 0.0
        if self._search is None:
            self._search = self._new_search()
        else:
            self._search.start_again()

    def _is_beaten(self, search: MapSearch) -> bool:
        """Whether the search has found a place that explains the scans clearly better."""
        if search.health is not Health.LOCALIZED or self.estimate is None:
            return False
        assert search.hypothesis is not None
        if is_same(search.hypothesis.pose, self.estimate.pose):
            return True
        odds = search.odds_against(self.estimate.pose)
        if self.estimate.health is Health.LOST and self._refuted:
            return odds > 0.0
        return odds > FOUND_ODDS and search.stops >= FOUND_STOPS

    def _found(self, t: float, odometry: Pose, search: MapSearch) -> Estimate:
        """Return the estimate by a search; where it has found the robot, it is tracked from now."""
        assert search.hypothesis is not None
        if search.health is Health.LOCALIZED:
            self._filter.belief = search.belief
            self._filter.resample(self._limits)
            self._monitor = HealthMonitor(Health.LOCALIZED)
            self._tracking, self._search, self._rival = True, None, None
            self._search_due, self._contestable = 0.0, False
        return self._estimate_of(t, odometry, search.hypothesis, search.health)


def _apart(belief: Belief, count: int) -> list[Pose]:
    """Return the best particles of a belief that are different hypotheses, at most so many."""
    found: list[Pose] = []
    for index in np.argsort(-belief.weights, kind="stable"):
        pose = Pose(*belief.particles[index].tolist())
        if not any(is_same(pose, other) for other in found):
            found.append(pose)
            if len(found) == count:
                break
    return found
