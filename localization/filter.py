"""Particle filter over poses: predict by odometry, weight by scans, resample when needed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from localization.kld import SampleLimits, needed_samples
from localization.likelihood_field import LikelihoodField
from localization.motion_model import move_particles
from localization.resampling import draw_low_variance, effective_sample_size
from localization.settings import MotionNoise
from maps.pose import Pose

RESAMPLE_BELOW = 0.5  # effective share of the particles
_TEMPERED = 0.8  # factor on a scan's information, until enough particles stay effective
_MUCH_LARGER = 2.0  # times the needed number of particles, above which the set is reduced


@dataclass(frozen=True, slots=True, eq=False)
class Belief:
    """A weighted set of poses."""

    particles: NDArray[np.float64]
    """(n, 3) map_from_base, column-major in memory, as computations are by column."""
    weights: NDArray[np.float64]
    """(n,) summing to 1."""
    slips: NDArray[np.float32]
    """(n,) share of the last counted translation that each particle did not move."""

    @classmethod
    def uniform(cls, particles: NDArray[np.float64]) -> Belief:
        """Return the belief of particles (n, 3) of equal weight."""
        count = len(particles)
        return cls(particles, np.full(count, 1.0 / count), np.zeros(count, np.float32))

    def drawn(self, chosen: NDArray[np.intp]) -> Belief:
        """Return the belief of the particles with the chosen indices (m,), of equal weight."""
        count = len(chosen)
        return Belief(self.particles[chosen], np.full(count, 1.0 / count), self.slips[chosen])

    def mixed_with(self, other: Belief, share: float = 0.5) -> Belief:
        """Return the mixture of this belief, with a share of the weight, 0..1, and another."""
        return Belief(
            np.vstack((self.particles, other.particles)),
            np.concatenate((share * self.weights, (1.0 - share) * other.weights)),
            np.concatenate((self.slips, other.slips)),
        )


class ParticleFilter:
    """Particle filter of map_from_base against one likelihood field."""

    def __init__(
        self,
        motion: MotionNoise,
        field: LikelihoodField,
        rng: np.random.Generator,
    ) -> None:
        self.motion = motion
        self._field = field
        self._rng = rng
        self.restart(np.zeros((1, 3)))

    def restart(self, particles: NDArray[np.float64]) -> None:
        """Replace the belief by particles (n, 3) of equal weight."""
        self.belief = Belief.uniform(particles)

    @property
    def belief(self) -> Belief:
        """The present belief; can be set."""
        return Belief(self.particles, self.weights, self._slips)

    @belief.setter
    def belief(self, belief: Belief) -> None:
        self.particles = np.asfortranarray(belief.particles)
        self.weights, self._slips = belief.weights, belief.slips
        self.effective_sample_size = effective_sample_size(self.weights)

    def drawn(self, count: int) -> Belief:
        """Return a belief of ``count`` particles drawn by their weights."""
        return self.belief.drawn(self._draw(count))

    def rule_out(self, impossible: NDArray[np.bool_]) -> bool:
        """Set the weights of ``impossible`` particles (n,) to 0.

        Returns False, and changes nothing, if no weight would be left.
        """
        left = np.where(impossible, 0.0, self.weights)
        total = float(left.sum())
        if total <= 0.0:
            return False
        self.weights = left / total
        self.effective_sample_size = effective_sample_size(self.weights)
        return True

    def scatter(self, sigma_xy: float, sigma_theta: float) -> None:
        """Add Gaussian noise to every particle; standard deviations in m and rad."""
        sigmas = (sigma_xy, sigma_xy, sigma_theta)
        self.particles = self.particles + self._rng.standard_normal(self.particles.shape) * sigmas

    def predict(self, increment: Pose) -> None:
        """Move the particles by a step of the odometry (base_then_from_base_now)."""
        self.particles, self._slips = move_particles(
            self.particles, self._slips, increment, self.motion, self._rng
        )

    def weigh(
        self,
        points: NDArray[np.float64],
        independent_beams: float,
        min_effective: float = 0.0,
        min_log_likelihood: float = -math.inf,
        beams: int | None = None,
        *,
        through_walls: bool = False,
    ) -> None:
        """Multiply the weights by the likelihood of a scan's end points (m, 2) in base_link.

        independent_beams: number of independent beams the scan counts as (its information weight).
        min_effective: share of the particles that must stay effective; the scan's information is
        reduced until they do, so that one particle that fits by chance does not outweigh a place
        where none does.
        min_log_likelihood: lower bound of the scan's; below it people are assumed to occlude the
        map. beams, through_walls: as of ``LikelihoodField.log_weights``.
        """
        with np.errstate(divide="ignore"):
            prior = np.log(self.weights)
        evidence = self._field.log_weights(
            self.particles, points, independent_beams, beams, through_walls=through_walls
        )
        np.maximum(evidence, min_log_likelihood, out=evidence)
        before = effective_sample_size(self.weights)
        required = min(min_effective * len(self.weights), _TEMPERED * before)
        while True:
            log_weights = prior + evidence
            weights = np.exp(log_weights - log_weights.max())
            self.weights = weights / weights.sum()
            self.effective_sample_size = effective_sample_size(self.weights)
            if self.effective_sample_size >= required:
                return
            evidence *= _TEMPERED

    def resample(self, limits: SampleLimits) -> None:
        """Resample if the effective sample size is small or there are far too many particles.

        limits: of the number of particles after that.
        """
        count = len(self.weights)
        if self.effective_sample_size < RESAMPLE_BELOW * count:
            drawn = self._draw(count)
            needed = needed_samples(_rows(self.particles, drawn), limits)
            if needed != count:
                drawn = self._draw(needed)
        else:
            needed = needed_samples(self.particles, limits)
            if count <= _MUCH_LARGER * needed:
                return
            drawn = self._draw(needed)
        self.particles, self._slips = _rows(self.particles, drawn), self._slips.take(drawn)
        self.weights = np.full(needed, 1.0 / needed)

    def _draw(self, count: int) -> NDArray[np.intp]:
        return draw_low_variance(self.weights, count, self._rng)


def _rows(particles: NDArray[np.float64], chosen: NDArray[np.intp]) -> NDArray[np.float64]:
    """Return the particles (n, 3) with the chosen indices (m,), column-major in memory."""
    return particles.T.take(chosen, axis=1).T
