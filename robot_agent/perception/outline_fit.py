"""Fit of a Pioneer's outline to the points of segments: centre, covariance and misfit.

The outline is a rectangle of unknown heading. For each of a grid of headings the centre is found by
least squares: every point lies on the nearest side, and where a beam passes an edge of the segment,
the outline's edge lies between that beam and the last one that hit. The centre is the mean over the
headings, weighted by their likelihoods; its covariance contains the uncertainty given the points
and that over the headings. All segments of a scan are fitted at once.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

# ARIA's p2dx.p: the body with its bumpers.
HALF_LENGTH, HALF_WIDTH = 0.2555, 0.2125  # m

_HEADINGS = 18  # over half a turn: a rectangle is symmetric under half a turn
_STEPS = 2  # iterations of the assignment of points to sides
_MAX_POINTS = 20  # of one segment; more add no information
_POINT_SIGMA = 0.02  # m; range noise, and deviation of the body from a rectangle
_FIRST_SIGMA = 0.15  # m; prior of the centre, which fixes it where no point does
_MIN_VARIANCE = 0.012**2  # m^2; errors that all points of a segment share

_THETA = np.arange(_HEADINGS) * (math.pi / _HEADINGS)
_COS, _SIN = np.cos(_THETA), np.sin(_THETA)
_TO_U = np.column_stack((_COS, _SIN))  # (headings, 2): along the length
_TO_V = np.column_stack((-_SIN, _COS))  # (headings, 2): along the width


@dataclass(frozen=True, slots=True)
class SightEdge:
    """An edge of a segment that the next beam passes.

    normal_x, normal_y: unit vector in base_link, across the line of sight, out of the segment.
    offset: m along it, half-way between the last beam that hit and the next. sigma: m, of the
    offset.
    """

    normal_x: float
    normal_y: float
    offset: float
    sigma: float


@dataclass(frozen=True, slots=True)
class OutlineFit:
    """Result of the fit to one segment.

    x, y: centre in base_link, m. var_x, var_y, cov_xy: its covariance, m^2, base_link. misfit:
    squared residuals over their variances, per point and edge, at the best heading; about 0.5 for
    a robot.
    """

    x: float
    y: float
    var_x: float
    var_y: float
    cov_xy: float
    misfit: float


def fit_outlines(
    parts: Sequence[NDArray[np.float64]],
    centres: Sequence[tuple[float, float]],
    edges: Sequence[Sequence[SightEdge]],
) -> list[OutlineFit]:
    """Fit the outline to each of several segments.

    parts: (n, 2) points of each, m, base_link. centres: (x, y), m, prior of each one's centre.
    edges: the visible ones of each, none to two. Returns one fit for each segment, in order.
    """
    if not parts:
        return []
    points = _Points.of(parts)
    sights = _Edges.of(edges, len(parts))
    # 1. At each heading, the centre that fits best.
    first = np.array(centres).T
    start = _Centres(_TO_U @ first, _TO_V @ first)
    centre = start
    for _ in range(_STEPS):
        system = _system(points, sights, start, centre)
        centre = system.solution()
    # 2. The likelihood of each heading from the residuals there.
    chi2 = points.chi2(centre) + sights.chi2(centre.u, centre.v)
    best = chi2.min(axis=0)
    weights = np.exp(-0.5 * (chi2 - best))
    weights /= weights.sum(axis=0)
    # 3. The mean over the headings, in base_link.
    misfit = best / (points.counts + sights.count)
    rows = np.vstack((_mean_over_headings(system, centre, weights), misfit))
    return [OutlineFit(*row) for row in rows.T.tolist()]


class _Centres(NamedTuple):
    """Centres (headings, segments), m: along the outline's length and its width."""

    u: NDArray[np.float64]
    v: NDArray[np.float64]


class _System(NamedTuple):
    """Normal equations of the centres, (headings, segments): a symmetric 2x2 matrix each."""

    uu: NDArray[np.float64]
    uv: NDArray[np.float64]
    vv: NDArray[np.float64]
    right_u: NDArray[np.float64]
    right_v: NDArray[np.float64]

    @property
    def determinant(self) -> NDArray[np.float64]:
        return self.uu * self.vv - self.uv * self.uv

    def solution(self) -> _Centres:
        determinant = self.determinant
        return _Centres(
            (self.vv * self.right_u - self.uv * self.right_v) / determinant,
            (self.uu * self.right_v - self.uv * self.right_u) / determinant,
        )


@dataclass(frozen=True, slots=True)
class _Points:
    """The points of all segments, seen at each heading."""

    u: NDArray[np.float64]
    """(headings, points) m along the length."""
    v: NDArray[np.float64]
    """(headings, points) m along the width."""
    owner: NDArray[np.intp]
    """(points,) segment of each."""
    starts: NDArray[np.intp]
    """(segments,) first point of each."""
    counts: NDArray[np.intp]
    """(segments,) points of each."""

    @classmethod
    def of(cls, parts: Sequence[NDArray[np.float64]]) -> _Points:
        """Take the points of each segment, thinned evenly to at most _MAX_POINTS."""
        parts = [part[:: math.ceil(len(part) / _MAX_POINTS)] for part in parts]
        counts = np.array([len(part) for part in parts])
        starts = np.concatenate(([0], np.cumsum(counts)[:-1]))
        points = np.concatenate(parts).T
        owner = np.repeat(np.arange(len(parts)), counts)
        return cls(_TO_U @ points, _TO_V @ points, owner, starts, counts)

    def off(self, centre: _Centres) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return (headings, points) offsets from the segments' centres, u and v, m."""
        return self.u - centre.u[:, self.owner], self.v - centre.v[:, self.owner]

    def summed(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return (headings, segments) sums of values (headings, points)."""
        return np.add.reduceat(values, self.starts, axis=1)

    def chi2(self, centre: _Centres) -> NDArray[np.float64]:
        """Return (headings, segments) squared distances from the outline over their variance."""
        off_u, off_v = self.off(centre)
        residuals = np.maximum(np.abs(off_u) - HALF_LENGTH, np.abs(off_v) - HALF_WIDTH)
        return self.summed(residuals * residuals) / _POINT_SIGMA**2


def _system(points: _Points, sights: _Edges, start: _Centres, centre: _Centres) -> _System:
    """Return the equations with every point on the nearest side of the outline at ``centre``.

    A point on an end constrains the centre along the length, one on a side along the width.
    """
    off_u, off_v = points.off(centre)
    on_end = np.abs(off_u) - HALF_LENGTH > np.abs(off_v) - HALF_WIDTH
    by_u = np.where(on_end, points.u - np.copysign(HALF_LENGTH, off_u), 0.0)
    by_v = np.where(on_end, 0.0, points.v - np.copysign(HALF_WIDTH, off_v))
    ends = points.summed(on_end.astype(np.float64))
    a, b = 1.0 / _FIRST_SIGMA**2, 1.0 / _POINT_SIGMA**2
    return _System(
        uu=a + b * ends + sights.uu,
        uv=sights.uv,
        vv=a + b * (points.counts - ends) + sights.vv,
        right_u=a * start.u + b * points.summed(by_u) + sights.right_u,
        right_v=a * start.v + b * points.summed(by_v) + sights.right_v,
    )


def _mean_over_headings(
    system: _System, centre: _Centres, weights: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return (5, segments) x, y, var_x, var_y, cov_xy in base_link; weights (headings, segments).

    The covariance is the mean of that at each heading plus the spread over the headings.
    """
    cos, sin = _COS[:, None], _SIN[:, None]
    x, y = cos * centre.u - sin * centre.v, sin * centre.u + cos * centre.v
    mean_x, mean_y = (weights * x).sum(axis=0), (weights * y).sum(axis=0)
    determinant = system.determinant
    var_u, var_v = system.vv / determinant, system.uu / determinant
    cov_uv = -system.uv / determinant
    dx, dy = x - mean_x, y - mean_y
    twice = 2.0 * cos * sin * cov_uv
    var_x = cos * cos * var_u + sin * sin * var_v - twice + dx * dx
    var_y = sin * sin * var_u + cos * cos * var_v + twice + dy * dy
    cov_xy = cos * sin * (var_u - var_v) + (cos * cos - sin * sin) * cov_uv + dx * dy
    return np.array(
        (
            mean_x,
            mean_y,
            (weights * var_x).sum(axis=0) + _MIN_VARIANCE,
            (weights * var_y).sum(axis=0) + _MIN_VARIANCE,
            (weights * cov_xy).sum(axis=0),
        )
    )


@dataclass(frozen=True, slots=True)
class _Edges:
    """The visible edges as equations for the centre, at each heading; (headings, segments).

    An edge requires the outline's farthest corner along its normal to be at its offset.
    """

    uu: NDArray[np.float64]
    uv: NDArray[np.float64]
    vv: NDArray[np.float64]
    right_u: NDArray[np.float64]
    right_v: NDArray[np.float64]
    square: NDArray[np.float64]
    count: NDArray[np.float64]
    """(segments,) number of visible edges of each."""

    @classmethod
    def of(cls, edges: Sequence[Sequence[SightEdge]], segments: int) -> _Edges:
        """Return the equations of each segment's edges."""
        sums = np.zeros((6, _HEADINGS, segments))
        count = np.zeros(segments)
        for index, own in enumerate(edges):
            for edge in own:
                normal = np.array((edge.normal_x, edge.normal_y))
                nu, nv = _TO_U @ normal, _TO_V @ normal
                target = edge.offset - HALF_LENGTH * np.abs(nu) - HALF_WIDTH * np.abs(nv)
                terms = (nu * nu, nu * nv, nv * nv, nu * target, nv * target, target * target)
                sums[:, :, index] += np.array(terms) / edge.sigma**2
                count[index] += 1.0
        uu, uv, vv, right_u, right_v, square = sums
        return cls(uu, uv, vv, right_u, right_v, square, count)

    def chi2(self, u: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the squared residuals over their variances for centres (headings, segments)."""
        linear = self.right_u * u + self.right_v * v
        squares = self.uu * u * u + 2.0 * self.uv * u * v + self.vv * v * v
        return np.asarray(squares - 2.0 * linear + self.square)
