"""The localizer: odometry and scans in, pose with covariance and health out."""

from __future__ import annotations

import math

import msgspec
import numpy as np
from numpy.typing import NDArray

from localization.cluster import best_cluster
from localization.estimate import Estimate
from localization.filter import ParticleFilter
from localization.global_search import GlobalSearch
from localization.health import Health, HealthMonitor
from localization.likelihood_field import LikelihoodField
from localization.refinement import Refinement
from localization.settings import LocalizationSettings
from maps.occupancy_map import OccupancyMap
from maps.pose import Pose


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
        self._search = GlobalSearch(settings.search, occupancy)
        # A number fixed for tracking would be too small for a search.
        self._search_samples = msgspec.structs.replace(
            settings.samples, fixed=None, maximum=settings.search.maximum_after
        )
        # How much an update adds to the doubt that, once whole, starts a search.
        self._doubt_of = {
            Health.LOST: 1.0 / (settings.search.after_lost or math.inf),
            Health.UNSURE: 1.0 / (settings.search.after_unsure or math.inf),
        }
        self._monitor = HealthMonitor(settings.health)
        self._started = False
        self._searching = False
        self._last_odometry: Pose | None = None
        self._doubt = 0.0
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
        self._searching = False

    def start_anywhere(self) -> None:
        """Believe in nothing: the robot may stand anywhere on the map's free floor.

        Raises MapError on a map without free floor.
        """
        self._start_with(self._search.sample(self._rng), Health.LOST)
        self._searching = True

    def _start_with(self, particles: NDArray[np.float64], health: Health) -> None:
        self._filter.restart(particles)
        self._monitor = HealthMonitor(self._settings.health, health)
        self._started = True
        self._last_odometry = None
        self._doubt = 0.0
        self.estimate = None

    def update(self, t: float, odometry: Pose, points: NDArray[np.float64]) -> Estimate:
        """Take in a scan and return the new estimate.

        t: when the scan was measured, s. odometry: odom_from_base then. points: (n, 2) end points
        of the beams that returned, m, base_link. Raises RuntimeError before a start.
        """
        if not self._started:
            raise RuntimeError("the localizer was told no start: call start_at or start_anywhere")
        if self._doubt >= 1.0 and self._search.possible:
            self._search_again()
        # 1. Move the particles by what the wheels counted since the last scan.
        increment = None if self._last_odometry is None else self._last_odometry.between(odometry)
        if increment is not None:
            self._filter.predict(increment)
        self._last_odometry = odometry
        # 2. Weigh them by the scan.
        self._filter.weigh(points, self._worth(increment))
        # 3. Estimate from the best cluster, slid to where the scan fits best.
        self.estimate = self._estimate(t, odometry, points)
        # 4. Renew the set for the next scan.
        self._filter.resample(self._search_samples if self._searching else self._settings.samples)
        return self.estimate

    def _search_again(self) -> None:
        """Search the whole map, but keep the old belief: a crowd may only have hidden the map."""
        self._filter.doubt(self._search.sample(self._rng), self._settings.search.kept)
        self._searching = True
        self._doubt = 0.0

    def _worth(self, increment: Pose | None) -> float:
        """Return how many independent beams a scan is worth after a step (None: the first).

        Scans from the same spot repeat each other's errors; taken at full worth they would breed
        a false confidence.
        """
        sensor = self._settings.sensor
        beams = (
            self._settings.search.independent_beams if self._searching else sensor.independent_beams
        )
        if increment is None:
            return beams
        travel = math.hypot(increment.x, increment.y) / sensor.full_step_xy
        step = max(travel, abs(increment.theta) / sensor.full_step_theta)
        return beams * min(1.0, max(sensor.still_worth, step))

    def _estimate(self, t: float, odometry: Pose, points: NDArray[np.float64]) -> Estimate:
        cluster = best_cluster(self.particles, self.weights)
        refined = self._refinement.refine(cluster.mean, cluster.covariance, points)
        pose = cluster.mean if refined is None else refined
        likelihood = self._refinement.fit(pose, points, self._settings.health.sigma)
        health = self._monitor.update(likelihood, cluster.spread, cluster.share)
        if health is Health.LOCALIZED:
            self._doubt, self._searching = 0.0, False
        elif likelihood is not None and likelihood < self._settings.health.localized_above:
            self._doubt += self._doubt_of[health]
        return Estimate(
            t=t,
            pose=pose,
            odometry=odometry,
            covariance=cluster.covariance,
            health=health,
            particle_count=len(self.weights),
            effective_sample_size=self._filter.effective_sample_size,
            likelihood=0.0 if likelihood is None else likelihood,
            cluster_share=cluster.share,
            refined=refined is not None,
        )
