"""Scans of which a share of the beams ends before what the map shows, for studies."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tools.logs.log_step import LogStep

NEAREST = 0.3  # m; a short beam is at least so long
PERSON_WIDTH = 0.44  # m; breadth of an adult's shoulders
PERSON_REACH = (0.6, 2.5)  # m; distance of people round a guide
SEED = 1


@dataclass(frozen=True, slots=True)
class Occlusion:
    """Occludes a share of each scan's beams, other ones at each scan."""

    share: float
    """Of the beams, 0 to 1."""
    by_people: bool
    """By people side by side, each over neighbouring beams; else each beam for itself."""

    def of(self, steps: Sequence[LogStep]) -> list[LogStep]:
        """Return the steps with occluded scans; the same for the same steps."""
        rng = np.random.default_rng(SEED)
        shorten = self._behind_people if self.by_people else self._short
        return [dataclasses.replace(step, points=shorten(step.points, rng)) for step in steps]

    def _short(self, points: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        """Return points (n, 2), m, of which a share is anywhere along its beam."""
        lengths = np.hypot(*points.T)
        chosen = (rng.random(len(points)) < self.share) & (lengths > NEAREST)
        factors = np.ones(len(points))
        factors[chosen] = rng.uniform(NEAREST / lengths[chosen], 1.0)
        return np.asarray(points * factors[:, np.newaxis])

    def _behind_people(
        self, points: NDArray[np.float64], rng: np.random.Generator
    ) -> NDArray[np.float64]:
        """Return points (n, 2), m, with people standing before a share of them."""
        lengths, bearings = np.hypot(*points.T), np.arctan2(points[:, 1], points[:, 0])
        nearer = lengths.copy()
        wanted = self.share * np.count_nonzero(lengths > PERSON_REACH[0])
        for _ in range(len(points)):  # at most: people stand before each other
            if np.count_nonzero(nearer < lengths) >= wanted:
                break
            away, middle = rng.uniform(*PERSON_REACH), rng.choice(bearings)
            half = math.atan2(0.5 * PERSON_WIDTH, away)
            off = np.abs(np.angle(np.exp(1j * (bearings - middle))))
            nearer[off < half] = np.minimum(nearer[off < half], away)
        return np.asarray(points * (nearer / np.maximum(lengths, 1e-9))[:, np.newaxis])
