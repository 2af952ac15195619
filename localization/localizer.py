"""The localizer: pose estimate with covariance and health from odometry and scans."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from localization.alternative_hypothesis import AlternativeSearch
from localization.cluster import Cluster, best_cluster
from localization.estimate import Estimate
from localization.filter import ParticleFilter
from localization.global_search import GlobalSearch
from localization.health import (
    LOCALIZED_ABOVE,
    LOCALIZED_SHARE,
    LOCALIZED_WALL_CROSSING,
    Evidence,
    Health,
    HealthMonitor,
)
from localization.kld import SampleLimits
from localization.likelihood_field import LikelihoodField
from localization.refinement import Refined, Refinement
from localization.scan_check import Fit, ScanCheck
from localization.settings import LocalizationSettings, MotionNoise
from localization.slip_search import SlipSearch
from maps.occupancy_map import OccupancyMap
from maps.pose import Pose

MIN_SIGMA_XY = 0.0144  # m; lower bound of an estimate's: quantization by a cell of 0.05 m
MIN_SIGMA_THETA = 0.005  # rad; likewise: error of the laser's mount
INDEPENDENT_BEAMS = 12.0  # that the beams of one scan count as together

# The information weight of a scan.
FULL_STEP_XY = 0.2  # m of travel after which a scan counts in full
FULL_STEP_THETA = 0.2  # rad of turning likewise
STILL_INFORMATION = 0.3  # of a scan at the pose of the last one, whose errors it repeats
_STILL_DECAY = 0.8  # factor on that in a search, from one scan to the next at one place

# The search in a window round the estimate, when a scan does not fit at the predicted pose.
WINDOW_BELOW = 0.8  # fit of a scan, without dynamic beams, that starts it
WINDOW_ABOVE = 0.75  # fit of a pose that is preferred
WINDOW_GAIN = 0.1  # by which it must fit better
WINDOW_SAMPLES = 3000
WINDOW_XY = 1.0  # m either way
WINDOW_THETA = 0.6  # rad either way

# The search over the whole map.
MAX_SEARCH_PARTICLES = 20_000  # during a search, after the first scan
KEPT_PARTICLES = 1000  # of the old belief, when a search starts
REPEAT_LOST = 15.0  # lost scans until the search starts again
REPEAT_UNSURE = 4.0  # unsure scans with a bad fit until then
_WINDOW_STEP = 0.2  # of a window's reach: spacing of samples, for the refinement's prior
_SLIPPED = 0.8  # share of the belief moved to a pose found back along the last step


@dataclass(frozen=True, slots=True, eq=False)
class _Hypothesis:
    """The pose hypothesis after one scan, with its evidence."""

    cluster: Cluster
    refined: Refined | None
    pose: Pose
    fit: Fit | None
    relocated: bool = False
    """Whether the scan fits only away from where the odometry puts the pose."""


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
        field = LikelihoodField(occupancy, settings.beams)
        self._settings = settings
        motion = settings.motion.over(MotionNoise())
        self._filter = ParticleFilter(motion, field, rng)
        self._refinement = Refinement(occupancy)
        self._slips = SlipSearch(field, self._refinement)
        self._check = ScanCheck(occupancy, self._refinement.surface)
        self._search = GlobalSearch(occupancy)
        self._limits = SampleLimits(
            settings.min_particles, settings.max_particles, settings.particles
        )
        # A number fixed for tracking would be too small for a search.
        self._search_limits = SampleLimits(settings.min_particles, MAX_SEARCH_PARTICLES)
        self._alternatives = AlternativeSearch(
            motion, self._search_limits, field, self._refinement, self._search, rng
        )
        self._min_covariance = np.diag(np.square((MIN_SIGMA_XY, MIN_SIGMA_XY, MIN_SIGMA_THETA)))
        self._monitor = HealthMonitor()
        self._started = False
        self._searching = False
        # Whether the pose is checked against alternative hypotheses before it becomes localized.
        self._contestable = False
        self._last_odometry: Pose | None = None
        self._still_scans = 0
        self._search_due = 0.0  # 0 to 1; at 1 a search of the whole map starts
        self.estimate: Estimate | None = None

    def use_noise(self, noise: MotionNoise) -> None:
        """Take the noise of the robot's odometry, where the settings leave it open."""
        self._filter.motion = self._alternatives.motion = self._settings.motion.over(noise)

    @property
    def particles(self) -> NDArray[np.float64]:
        """Present particles (n, 3), map_from_base."""
        return self._filter.particles

    @property
    def weights(self) -> NDArray[np.float64]:
        """Present weights (n,), summing to 1."""
        return self._filter.weights

    def start_at(self, pose: Pose, sigma_xy: float, sigma_theta: float) -> None:
        """Start at a pose (map_from_base), with standard deviations in m and rad."""
        limits = self._limits
        count = limits.fixed if limits.fixed is not None else limits.maximum
        scatter = self._rng.standard_normal((count, 3)) * (sigma_xy, sigma_xy, sigma_theta)
        self._start_with(np.array(pose) + scatter, Health.UNSURE)
        self._searching = self._contestable = False

    def start_anywhere(self) -> None:
        """Start a global search, with particles all over the map's free floor.

        Raises MapError on a map without free floor.
        """
        self._start_with(self._search.sample(self._rng), Health.LOST)
        self._searching = self._contestable = True

    def _start_with(self, particles: NDArray[np.float64], health: Health) -> None:
        self._filter.restart(particles)
        self._alternatives.forget()
        self._monitor = HealthMonitor(health)
        self._started = True
        self._last_odometry = None
        self._search_due = 0.0
        self.estimate = None

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
        if not self._started:
            raise RuntimeError("the localizer was told no start: call start_at or start_anywhere")
        if ignore is not None:
            points = points[~ignore]
        # 1. Predict by the odometry since the last scan.
        increment = None if self._last_odometry is None else self._last_odometry.between(odometry)
        if increment is not None:
            self._filter.predict(increment)
        self._last_odometry = odometry
        points = self._without_occluder(odometry, points)
        if self._contestable:
            self._alternatives.remember(increment, points)
        # 2. Weight the particles by the scan.
        information = self._information(increment)
        if self._search_due >= 1.0 and self._search.possible:
            self._search_again(points)
        elif self._searching and increment is None:
            self._search.weigh_first(self._filter, points, self._search_limits)
        else:
            self._weigh(points, information)
        # 3. Take the best cluster, refined by the scan.
        hypothesis = self._best_hypothesis(points)
        # 4. Against slip: try poses back along the step, and, if the fit is bad, a window.
        if not self._searching:
            hypothesis = self._search_slip(hypothesis, increment, points)
            hypothesis = self._search_window(hypothesis, points, information)
        # 5. Determine health and covariance.
        self.estimate = self._make_estimate(t, odometry, points, hypothesis, information)
        # 6. Resample for the next scan.
        self._filter.resample(self._search_limits if self._searching else self._limits)
        return self.estimate

    def disown(self, estimate: Estimate) -> Estimate:
        """Return the latest estimate as a lost one: other evidence shows it to be wrong."""
        self.estimate = replace(estimate, health=Health.LOST)
        return self.estimate

    def _without_occluder(self, odometry: Pose, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return points (n, 2) without those on a large unmapped object close to the robot.

        All points while lost or searching: the pose is not good enough to detect one.
        """
        if self.estimate is None or self.estimate.health is Health.LOST or self._searching:
            return points
        hiding = self._check.hiding(self.estimate.pose_at(odometry), points)
        return points if hiding is None else points[~hiding]

    def _search_again(self, points: NDArray[np.float64]) -> None:
        """Start a search: mix particles all over the map with the old ones.

        The old ones may be right if people occlude the map.
        """
        kept = self._filter.drawn(KEPT_PARTICLES)
        self._filter.restart(self._search.sample(self._rng))
        self._search.weigh_first(self._filter, points, self._search_limits)
        self._filter.belief = kept.mixed_with(self._filter.belief)
        self._alternatives.forget()
        self._alternatives.remember(None, points)
        self._searching = self._contestable = True
        self._search_due = 0.0

    def _information(self, increment: Pose | None) -> float:
        """Return this scan's information weight, 0 to 1, after a step (None: the first scan).

        Errors of scans from the same place are correlated; at full weight the covariance would
        become too small. During a search, which must not decide between two places by such errors,
        their weight decays from scan to scan.
        """
        if increment is None:
            return 1.0
        travel = math.hypot(increment.x, increment.y) / FULL_STEP_XY
        step = max(travel, abs(increment.theta) / FULL_STEP_THETA)
        still = STILL_INFORMATION
        self._still_scans = 0 if step > still else self._still_scans + 1
        if self._searching:
            still *= _STILL_DECAY**self._still_scans
        return min(1.0, max(still, step))

    def _weigh(self, points: NDArray[np.float64], information: float) -> None:
        if self._searching:
            self._search.weigh(self._filter, points, information)
        else:
            self._filter.weigh(points, information * INDEPENDENT_BEAMS)

    def _best_hypothesis(self, points: NDArray[np.float64]) -> _Hypothesis:
        """Return the best cluster with its pose refined by the scan."""
        cluster = best_cluster(self.particles, self.weights)
        refined = self._refinement.refine(cluster.mean, cluster.covariance, points)
        pose = cluster.mean if refined is None else refined.pose
        return _Hypothesis(cluster, refined, pose, self._check.fit(pose, points))

    def _search_slip(
        self, hypothesis: _Hypothesis, increment: Pose | None, points: NDArray[np.float64]
    ) -> _Hypothesis:
        """Return the hypothesis moved back along the last step if the scan fits better there."""
        if increment is None:
            return hypothesis
        slipped = self._slips.find(hypothesis.pose, increment, points)
        if slipped is None:
            return hypothesis
        pose, belief = slipped.pose, self._filter.belief
        back = (pose.x - hypothesis.pose.x, pose.y - hypothesis.pose.y, 0.0)
        moved = replace(belief, particles=belief.particles + back)
        self._filter.belief = moved.mixed_with(belief, _SLIPPED)
        cluster = replace(hypothesis.cluster, mean=pose)
        return _Hypothesis(cluster, slipped, pose, self._check.fit(pose, points))

    def _search_window(
        self, hypothesis: _Hypothesis, points: NDArray[np.float64], information: float
    ) -> _Hypothesis:
        """Return the best hypothesis in a window round a pose that the scan does not fit.

        Returns the given one if the scan fits it, or fits nowhere else clearly better.
        """
        before = self._filter.belief
        if hypothesis.fit is None or hypothesis.fit.fit_without_dynamic >= WINDOW_BELOW:
            return hypothesis
        reach = np.array((WINDOW_XY, WINDOW_XY, WINDOW_THETA))
        offsets = self._rng.uniform(-1.0, 1.0, (WINDOW_SAMPLES, 3)) * reach
        self._filter.restart(np.array(hypothesis.cluster.mean) + offsets)
        self._weigh(points, information)
        best = Pose(*self.particles[self.weights.argmax()].tolist())
        refined = self._refinement.refine(best, np.diag(np.square(_WINDOW_STEP * reach)), points)
        if refined is not None:
            fit = self._check.fit(refined.pose, points)
            needed = max(WINDOW_ABOVE, hypothesis.fit.whole + WINDOW_GAIN)
            # At a wrong pose beams cross mapped walls.
            wall_crossing = self._check.wall_crossing(refined.pose, points)
            possible = wall_crossing <= LOCALIZED_WALL_CROSSING
            if fit is not None and fit.whole >= needed and possible:
                self._restart_alternatives(points)
                cluster = best_cluster(self.particles, self.weights)
                return _Hypothesis(cluster, refined, refined.pose, fit, relocated=True)
        self._filter.belief = before
        return hypothesis

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
        hypothesis: _Hypothesis,
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
            share=cluster.share,
            relocated=hypothesis.relocated,
            wall_crossing=0.0 if good else self._check.wall_crossing(pose, points),
            jump_xy=math.hypot(jump.x, jump.y),
            jump_theta=abs(jump.theta),
            information=information,
        )
        if self._contestable and self._monitor.preview(evidence) is Health.LOCALIZED:
            evidence = self._contested(evidence, pose)
        health = self._monitor.update(evidence)
        self._update_search_due(before, health, hypothesis.fit, information)
        refined = hypothesis.refined
        covariance = cluster.covariance if refined is None else refined.covariance
        return Estimate(
            t=t,
            pose=pose,
            odometry=odometry,
            covariance=covariance + self._min_covariance,
            health=health,
            particle_count=len(self.weights),
            effective_sample_size=self._filter.effective_sample_size,
            likelihood=fit,
            refined=refined is not None,
        )

    def _contested(self, evidence: Evidence, pose: Pose) -> Evidence:
        """Return the evidence, with its share lowered if an alternative hypothesis is as likely.

        The particles are then a mixture of both. A pose found by a search must be clearly more
        likely than the alternative; one found near the predicted pose must only not be clearly
        less likely.
        """
        alternative, clear = self._alternatives.find(pose), LOCALIZED_SHARE
        if alternative is None or alternative.share >= (clear if self._searching else 1.0 - clear):
            return evidence
        self._filter.belief = self._filter.belief.mixed_with(alternative.belief, alternative.share)
        self._searching = True
        return replace(evidence, share=evidence.share * alternative.share)

    def _update_search_due(
        self, before: Health, health: Health, fit: Fit | None, information: float
    ) -> None:
        """Count up to the next search of the whole map: at once when lost, then repeatedly."""
        if health is Health.LOCALIZED:
            self._search_due, self._searching, self._contestable = 0.0, False, False
        elif health is Health.LOST and before is not Health.LOST and not self._searching:
            self._search_due = 1.0
        elif fit is not None and fit.whole < LOCALIZED_ABOVE:
            scans = REPEAT_LOST if health is Health.LOST else REPEAT_UNSURE
            self._search_due += information / scans
