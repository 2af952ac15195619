"""The localizer: odometry and scans in, pose with covariance and health out."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import msgspec
import numpy as np
from numpy.typing import NDArray

from localization.alternative_hypothesis import RivalSearch
from localization.cluster import Cluster, best_cluster
from localization.estimate import Estimate
from localization.filter import ParticleFilter
from localization.global_search import GlobalSearch
from localization.health import Evidence, Health, HealthMonitor
from localization.likelihood_field import LikelihoodField
from localization.refinement import Refined, Refinement
from localization.scan_check import Fit, ScanCheck
from localization.settings import LocalizationSettings
from localization.slip_search import SlipSearch
from maps.occupancy_map import OccupancyMap
from maps.pose import Pose

_WINDOW_STEP = 0.2  # of a window's reach, to the sample nearest to the best pose in it
_SLIPPED = 0.8  # of the belief goes to a place found back along the last step
_STILL_DECAY = 0.8  # of a scan's weight in a search, from one scan to the next on one spot


@dataclass(frozen=True, slots=True, eq=False)
class _Sight:
    """Where one scan is thought to be taken."""

    cluster: Cluster
    refined: Refined | None
    pose: Pose
    fit: Fit | None
    relocated: bool = False
    """Whether it is found only beside where the odometry puts it."""


class Localizer:
    """Monte Carlo localization of the base in a known map.

    There is no pose before ``start_at`` or ``start_anywhere``, then none before the first scan.
    """

    def __init__(
        self,
        settings: LocalizationSettings,
        occupancy: OccupancyMap,
        rng: np.random.Generator,
    ) -> None:
        self._settings = settings
        self._rng = rng
        field = LikelihoodField(settings.sensor, occupancy)
        self._filter = ParticleFilter(settings.motion, field, rng)
        self._refinement = Refinement(settings.refinement, occupancy)
        self._slips = SlipSearch(settings.slip, field, self._refinement)
        self._check = ScanCheck(settings.check, occupancy, self._refinement.surface)
        self._search = GlobalSearch(settings.search, occupancy)
        # A number fixed for tracking would be too small for a search.
        self._search_samples = msgspec.structs.replace(
            settings.samples, fixed=None, maximum=settings.search.maximum_after
        )
        self._alternatives = RivalSearch(
            settings, self._search_samples, field, self._refinement, self._search, rng
        )
        self._min_covariance = np.diag(
            np.square((settings.floor.xy, settings.floor.xy, settings.floor.theta))
        )
        self._monitor = HealthMonitor(settings.health)
        self._started = False
        self._searching = False
        self._uprooted = False  # whether it has gone where no odometry led, and not arrived yet
        self._last_odometry: Pose | None = None
        self._still_scans = 0
        self._doubt = 0.0  # once whole, the whole map is searched
        self.estimate: Estimate | None = None

    @property
    def particles(self) -> NDArray[np.float64]:
        """Present particles (n, 3), map_from_base."""
        return self._filter.particles

    @property
    def weights(self) -> NDArray[np.float64]:
        """Present weights (n,), summing to 1."""
        return self._filter.weights

    def start_at(self, pose: Pose, sigma_xy: float, sigma_theta: float) -> None:
        """Believe in a pose (map_from_base) with standard deviations in m and rad."""
        samples = self._settings.samples
        count = samples.fixed if samples.fixed is not None else samples.maximum
        scatter = self._rng.standard_normal((count, 3)) * (sigma_xy, sigma_xy, sigma_theta)
        self._start_with(np.array(pose) + scatter, Health.UNSURE)
        self._searching = self._uprooted = False

    def start_anywhere(self) -> None:
        """Believe in nothing: the robot may stand anywhere on the map's free floor.

        Raises MapError on a map without free floor.
        """
        self._start_with(self._search.sample(self._rng), Health.LOST)
        self._searching = self._uprooted = True

    def _start_with(self, particles: NDArray[np.float64], health: Health) -> None:
        self._filter.restart(particles)
        self._alternatives.forget()
        self._monitor = HealthMonitor(self._settings.health, health)
        self._started = True
        self._last_odometry = None
        self._doubt = 0.0
        self.estimate = None

    def update(
        self,
        t: float,
        odometry: Pose,
        points: NDArray[np.float64],
        ignore: NDArray[np.bool_] | None = None,
    ) -> Estimate:
        """Take in a scan and return the new estimate.

        t: when the scan was measured, s. odometry: odom_from_base then. points: (n, 2) end points
        of the beams that returned, m, base_link at that time, in the order of their bearing.
        ignore: (n,) the beams known to end on people or teammates. Raises RuntimeError before a
        start.
        """
        if not self._started:
            raise RuntimeError("the localizer was told no start: call start_at or start_anywhere")
        if ignore is not None:
            points = points[~ignore]
        # 1. Move the particles by what the wheels counted since the last scan.
        increment = None if self._last_odometry is None else self._last_odometry.between(odometry)
        if increment is not None:
            self._filter.predict(increment)
        self._last_odometry = odometry
        points = self._without_hiding(odometry, points)
        if self._uprooted:
            self._alternatives.remember(increment, points)
        # 2. Weigh them by the scan.
        information = self._information(increment)
        if self._doubt >= 1.0 and self._search.possible:
            self._search_again(points)
        elif self._searching and increment is None:
            self._search.weigh_first(self._filter, points, self._search_samples)
        else:
            self._weigh(points, information)
        # 3. Take the best cluster, slid to where the scan fits best.
        sight = self._look(points)
        # 4. Wheels slip: see whether the scan fits better behind, or, if badly, anywhere nearby.
        if not self._searching:
            sight = self._look_back(sight, increment, points)
            sight = self._look_around(sight, points, information)
        # 5. Judge how sure that is.
        self.estimate = self._judge(t, odometry, points, sight, information)
        # 6. Renew the set for the next scan.
        self._filter.resample(self._search_samples if self._searching else self._settings.samples)
        return self.estimate

    def _without_hiding(self, odometry: Pose, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Leave out what lies on a large unmapped thing before a robot that knows where it is."""
        if self.estimate is None or self.estimate.health is Health.LOST or self._searching:
            return points
        hiding = self._check.hiding(self.estimate.pose_at(odometry), points)
        return points if hiding is None else points[~hiding]

    def _search_again(self, points: NDArray[np.float64]) -> None:
        """Search the whole map, but keep the old belief: a crowd may only have hidden the map."""
        kept = self._filter.drawn(self._settings.search.kept)
        self._filter.restart(self._search.sample(self._rng))
        self._search.weigh_first(self._filter, points, self._search_samples)
        self._filter.belief = kept.mixed_with(self._filter.belief)
        self._alternatives.forget()
        self._alternatives.remember(None, points)
        self._searching = self._uprooted = True
        self._doubt = 0.0

    def _information(self, increment: Pose | None) -> float:
        """Return this scan's information weight, 0 to 1, after a step (None: the first scan).

        Scans from the same spot repeat each other's errors; taken at full weight they would
        breed a false confidence. A search, which must not decide between two places by such errors,
        takes them at less and less.
        """
        if increment is None:
            return 1.0
        sensor = self._settings.sensor
        travel = math.hypot(increment.x, increment.y) / sensor.full_step_xy
        step = max(travel, abs(increment.theta) / sensor.full_step_theta)
        self._still_scans = 0 if step > sensor.still_worth else self._still_scans + 1
        still_worth = sensor.still_worth
        if self._searching:
            still_worth *= _STILL_DECAY**self._still_scans
        return min(1.0, max(still_worth, step))

    def _weigh(self, points: NDArray[np.float64], information: float) -> None:
        if self._searching:
            self._search.weigh(self._filter, points, information)
        else:
            self._filter.weigh(points, information * self._settings.sensor.independent_beams)

    def _look(self, points: NDArray[np.float64]) -> _Sight:
        """Return the best cluster and the pose in it that the scan fits best."""
        cluster = best_cluster(self.particles, self.weights)
        refined = self._refinement.refine(cluster.mean, cluster.covariance, points)
        pose = cluster.mean if refined is None else refined.pose
        return _Sight(cluster, refined, pose, self._check.fit(pose, points))

    def _look_back(
        self, sight: _Sight, increment: Pose | None, points: NDArray[np.float64]
    ) -> _Sight:
        """Believe in a place back along the last step if the scan fits better there."""
        slipped = None if increment is None else self._slips.find(sight.pose, increment, points)
        if slipped is None:
            return sight
        pose, belief = slipped.pose, self._filter.belief
        back = (pose.x - sight.pose.x, pose.y - sight.pose.y, 0.0)
        moved = replace(belief, particles=belief.particles + back)
        self._filter.belief = moved.mixed_with(belief, _SLIPPED)
        cluster = replace(sight.cluster, mean=pose)
        return _Sight(cluster, slipped, pose, self._check.fit(pose, points))

    def _look_around(
        self, sight: _Sight, points: NDArray[np.float64], information: float
    ) -> _Sight:
        """Weigh poses in a window round a misfit; believe in them if the scan fits there."""
        before, window = self._filter.belief, self._settings.window
        if sight.fit is None or sight.fit.fit_without_dynamic >= window.below:
            return sight
        reach = np.array((window.reach_xy, window.reach_xy, window.reach_theta))
        offsets = self._rng.uniform(-1.0, 1.0, (window.samples, 3)) * reach
        self._filter.restart(np.array(sight.cluster.mean) + offsets)
        self._weigh(points, information)
        best = Pose(*self.particles[self.weights.argmax()].tolist())
        refined = self._refinement.refine(best, np.diag(np.square(_WINDOW_STEP * reach)), points)
        if refined is not None:
            fit = self._check.fit(refined.pose, points)
            needed = max(window.above, sight.fit.whole + window.gain)
            # A false fit is seen through walls.
            wall_crossing = self._check.through(refined.pose, points)
            possible = wall_crossing <= self._settings.health.localized_through
            if fit is not None and fit.whole >= needed and possible:
                self._uproot(points)
                cluster = best_cluster(self.particles, self.weights)
                return _Sight(cluster, refined, refined.pose, fit, relocated=True)
        self._filter.belief = before
        return sight

    def _uproot(self, points: NDArray[np.float64]) -> None:
        """Begin a new way: the robot is found where the odometry does not lead."""
        self._uprooted = True
        self._alternatives.forget()
        self._alternatives.remember(None, points)

    def _judge(
        self,
        t: float,
        odometry: Pose,
        points: NDArray[np.float64],
        sight: _Sight,
        information: float,
    ) -> Estimate:
        cluster, pose = sight.cluster, sight.pose
        last = self.estimate
        jump = Pose(0.0, 0.0, 0.0) if last is None else last.pose_at(odometry).between(pose)
        before = self._monitor.health
        # While all is well, following the beams through the map tells nothing new.
        seen = 0.0 if sight.fit is None else sight.fit.whole
        well = before is Health.LOCALIZED and seen >= self._settings.window.above
        evidence = Evidence(
            fit=sight.fit,
            spread=cluster.spread,
            share=cluster.share,
            relocated=sight.relocated,
            wall_crossing=0.0 if well else self._check.through(pose, points),
            jump_xy=math.hypot(jump.x, jump.y),
            jump_theta=abs(jump.theta),
            information=information,
        )
        if self._uprooted and self._monitor.preview(evidence) is Health.LOCALIZED:
            evidence = self._contested(evidence, pose)
        health = self._monitor.update(evidence)
        self._renew_doubt(before, health, sight.fit, information)
        covariance = cluster.covariance if sight.refined is None else sight.refined.covariance
        return Estimate(
            t=t,
            pose=pose,
            odometry=odometry,
            covariance=covariance + self._min_covariance,
            health=health,
            particle_count=len(self.weights),
            effective_sample_size=self._filter.effective_sample_size,
            likelihood=seen,
            refined=sight.refined is not None,
        )

    def _contested(self, evidence: Evidence, pose: Pose) -> Evidence:
        """Let the best other place contest a pose found; believe in both if it holds out.

        A search must win clearly. A pose found near where the odometry led has that in its favour,
        and must only not lose clearly.
        """
        alternative, clear = self._alternatives.find(pose), self._settings.health.localized_share
        if alternative is None or alternative.share >= (clear if self._searching else 1.0 - clear):
            return evidence
        self._filter.belief = self._filter.belief.mixed_with(alternative.belief, alternative.share)
        self._searching = True
        return replace(evidence, share=evidence.share * alternative.share)

    def _renew_doubt(
        self, before: Health, health: Health, fit: Fit | None, information: float
    ) -> None:
        """Count up to the next search of the whole map: at once when lost, then now and then."""
        search = self._settings.search
        if health is Health.LOCALIZED:
            self._doubt, self._searching, self._uprooted = 0.0, False, False
        elif health is Health.LOST and before is not Health.LOST and not self._searching:
            self._doubt = 1.0
        elif fit is not None and fit.whole < self._settings.health.localized_above:
            scans = search.repeat_lost if health is Health.LOST else search.repeat_unsure
            self._doubt += information / (scans or math.inf)
