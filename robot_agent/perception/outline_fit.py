"""Fit of teammates' silhouettes to the points of segments: centre, covariance and misfit.

The silhouettes admitted are convex polygons of unknown heading. For each of them, at each of a grid
of headings, the centre is found by least squares: every point lies on the nearest side, and where a
beam passes an edge of the segment, the outline's edge lies between that beam and the last one that
hit. The centre is the mean over these hypotheses, weighted by their likelihoods; its covariance
contains the uncertainty given the points and that over the hypotheses. All segments of a scan are
fitted at once.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robot_agent.perception.silhouette import Silhouettes

_STEPS = 2  # iterations of the assignment of points to sides
_MAX_POINTS = 20  # of one segment; more add no information
_POINT_SIGMA = 0.02  # m; range noise, and deviation of the body from a polygon
_FIRST_SIGMA = 0.15  # m; prior of the centre, which fixes it where no point does
_MIN_VARIANCE = 0.012**2  # m^2; errors that all points of a segment share


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
    squared residuals over their variances, per point and edge, of the best hypothesis; about 0.5
    for a robot. silhouette: index of that hypothesis's silhouette.
    """

    x: float
    y: float
    var_x: float
    var_y: float
    cov_xy: float
    misfit: float
    silhouette: int


def fit_outlines(
    silhouettes: Silhouettes,
    parts: Sequence[NDArray[np.float64]],
    centres: Sequence[tuple[float, float]],
    edges: Sequence[Sequence[SightEdge]],
    admitted: NDArray[np.bool_] | None = None,
) -> list[OutlineFit]:
    """Fit the silhouettes to each of several segments.

    parts: (n, 2) points of each, m, base_link. centres: (x, y), m, prior of each one's centre.
    edges: the visible ones of each, none to two. admitted: (segments, silhouettes) which may be
    which, one at least for each segment; None for all. Returns one fit for each segment, in order.
    """
    if not parts:
        return []
    chosen = _Hypotheses.of(silhouettes, len(parts), admitted)
    points = _Points.of(chosen, parts)
    sights = _Edges.of(chosen, edges)
    # 1. For each hypothesis, the centre that fits best.
    first = np.array(centres).T
    start = _Centres(*(np.broadcast_to(each, (len(chosen.owner), len(parts))) for each in first))
    centre = start
    for _ in range(_STEPS):
        system = _system(points, sights, start, centre)
        centre = system.solution()
    # 2. Their likelihoods from the residuals there.
    chi2 = points.chi2(centre) + sights.chi2(centre)
    chi2[~chosen.admitted] = np.inf
    best = chi2.min(axis=0)
    weights = np.exp(-0.5 * (chi2 - best)) * chosen.prior[:, None]
    weights /= weights.sum(axis=0)
    # 3. The mean over the hypotheses, in base_link.
    misfit = best / (points.counts + sights.count)
    rows = np.vstack((_mean(system, centre, weights), misfit)).T.tolist()
    owners = chosen.owner[chi2.argmin(axis=0)].tolist()
    return [
        OutlineFit(x, y, var_x, var_y, cov_xy, misfit, owner)
        for (x, y, var_x, var_y, cov_xy, misfit), owner in zip(rows, owners, strict=True)
    ]


class _Centres(NamedTuple):
    """Centres (hypotheses, segments), m, base_link."""

    x: NDArray[np.float64]
    y: NDArray[np.float64]


class _System(NamedTuple):
    """Normal equations of the centres, (hypotheses, segments): a symmetric 2x2 matrix each."""

    xx: NDArray[np.float64]
    xy: NDArray[np.float64]
    yy: NDArray[np.float64]
    right_x: NDArray[np.float64]
    right_y: NDArray[np.float64]

    @property
    def determinant(self) -> NDArray[np.float64]:
        return self.xx * self.yy - self.xy * self.xy

    def solution(self) -> _Centres:
        determinant = self.determinant
        return _Centres(
            (self.yy * self.right_x - self.xy * self.right_y) / determinant,
            (self.xx * self.right_y - self.xy * self.right_x) / determinant,
        )


class _Hypotheses(NamedTuple):
    """The silhouettes' hypotheses that any segment admits; arrays as in ``Silhouettes``.

    admitted: (hypotheses, segments) which may be which. prior: (hypotheses,).
    """

    normals: NDArray[np.float64]
    sides: NDArray[np.float64]
    corners: NDArray[np.float64]
    owner: NDArray[np.intp]
    prior: NDArray[np.float64]
    admitted: NDArray[np.bool_]

    @classmethod
    def of(
        cls, silhouettes: Silhouettes, segments: int, admitted: NDArray[np.bool_] | None
    ) -> _Hypotheses:
        """Take the hypotheses that any of the segments admits."""
        if admitted is None:
            admitted = np.ones((segments, len(silhouettes.shapes)), dtype=np.bool_)
        by_hypothesis = admitted.T[silhouettes.owner]
        used = by_hypothesis.any(axis=1)
        return cls(
            silhouettes.normals[:, :, used],
            silhouettes.sides[:, used],
            silhouettes.corners[:, :, used],
            silhouettes.owner[used],
            silhouettes.weights[used],
            by_hypothesis[used],
        )


@dataclass(frozen=True, slots=True)
class _Points:
    """The points of all segments, and how far they lie along each side's normal."""

    hypotheses: _Hypotheses
    along: NDArray[np.float64]
    """(sides, hypotheses, points) m along a side's normal, beyond the side of a polygon at 0."""
    owner: NDArray[np.intp]
    """(points,) segment of each."""
    starts: NDArray[np.intp]
    """(segments,) first point of each."""
    counts: NDArray[np.intp]
    """(segments,) points of each."""

    @classmethod
    def of(cls, hypotheses: _Hypotheses, parts: Sequence[NDArray[np.float64]]) -> _Points:
        """Take the points of each segment, thinned evenly to at most _MAX_POINTS."""
        parts = [part[:: math.ceil(len(part) / _MAX_POINTS)] for part in parts]
        counts = np.array([len(part) for part in parts])
        starts = np.concatenate(([0], np.cumsum(counts)[:-1]))
        x, y = np.concatenate(parts).T
        nx, ny = hypotheses.normals[..., None]
        along = nx * x + ny * y - hypotheses.sides[..., None]
        return cls(hypotheses, along, np.repeat(np.arange(len(parts)), counts), starts, counts)

    def beyond(self, centre: _Centres) -> NDArray[np.float64]:
        """Return (sides, hypotheses, points) distances, m, outside each side at the centres."""
        nx, ny = self.hypotheses.normals[..., None]
        return np.asarray(self.along - (nx * centre.x + ny * centre.y).take(self.owner, axis=-1))

    def summed(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return (..., segments) sums of values (..., points)."""
        return np.add.reduceat(values, self.starts, axis=-1)

    def chi2(self, centre: _Centres) -> NDArray[np.float64]:
        """Return (hypotheses, segments) squared distances from the sides over their variance."""
        residuals = self.beyond(centre).max(axis=0)
        return self.summed(residuals * residuals) / _POINT_SIGMA**2


def _system(points: _Points, sights: _Edges, start: _Centres, centre: _Centres) -> _System:
    """Return the equations with every point on the nearest side of the polygon at ``centre``.

    A point constrains the centre along the normal of its side.
    """
    nearest = points.beyond(centre).argmax(axis=0)
    hypotheses, count = nearest.shape
    # Flat indices: many times as fast here as indices by axis.
    side = nearest * hypotheses + np.arange(hypotheses)[:, None]
    nx, ny = (normals.take(side) for normals in points.hypotheses.normals)
    target = points.along.take(side * count + np.arange(count))
    a, b = 1.0 / _FIRST_SIGMA**2, 1.0 / _POINT_SIGMA**2
    terms = np.stack((nx * nx, nx * ny, ny * ny, nx * target, ny * target))
    xx, xy, yy, right_x, right_y = b * points.summed(terms)
    return _System(
        xx=a + xx + sights.xx,
        xy=xy + sights.xy,
        yy=a + yy + sights.yy,
        right_x=a * start.x + right_x + sights.right_x,
        right_y=a * start.y + right_y + sights.right_y,
    )


def _mean(system: _System, centre: _Centres, weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (5, segments) x, y, var_x, var_y, cov_xy; weights (hypotheses, segments).

    The covariance is the mean of that of each hypothesis plus the spread over them.
    """
    mean_x, mean_y = (weights * centre.x).sum(axis=0), (weights * centre.y).sum(axis=0)
    determinant = system.determinant
    dx, dy = centre.x - mean_x, centre.y - mean_y
    return np.array(
        (
            mean_x,
            mean_y,
            (weights * (system.yy / determinant + dx * dx)).sum(axis=0) + _MIN_VARIANCE,
            (weights * (system.xx / determinant + dy * dy)).sum(axis=0) + _MIN_VARIANCE,
            (weights * (dx * dy - system.xy / determinant)).sum(axis=0),
        )
    )


@dataclass(frozen=True, slots=True)
class _Edges:
    """The visible edges as equations for the centre, (hypotheses, segments).

    An edge requires the outline's farthest corner along its normal to be at its offset.
    """

    xx: NDArray[np.float64]
    xy: NDArray[np.float64]
    yy: NDArray[np.float64]
    right_x: NDArray[np.float64]
    right_y: NDArray[np.float64]
    square: NDArray[np.float64]
    count: NDArray[np.float64]
    """(segments,) number of visible edges of each."""

    @classmethod
    def of(cls, hypotheses: _Hypotheses, edges: Sequence[Sequence[SightEdge]]) -> _Edges:
        """Return the equations of each segment's edges."""
        sums = np.zeros((6, len(hypotheses.owner), len(edges)))
        for index, own in enumerate(edges):
            for edge in own:
                nx, ny = edge.normal_x, edge.normal_y
                farthest = (nx * hypotheses.corners[0] + ny * hypotheses.corners[1]).max(axis=0)
                target = (edge.offset - farthest) / edge.sigma
                sx, sy = nx / edge.sigma, ny / edge.sigma
                for row, term in enumerate(
                    (sx * sx, sx * sy, sy * sy, sx * target, sy * target, target * target)
                ):
                    sums[row, :, index] += term
        count = np.array([float(len(own)) for own in edges])
        xx, xy, yy, right_x, right_y, square = sums
        return cls(xx, xy, yy, right_x, right_y, square, count)

    def chi2(self, centre: _Centres) -> NDArray[np.float64]:
        """Return the squared residuals over their variances for the centres."""
        x, y = centre
        linear = self.right_x * x + self.right_y * y
        squares = self.xx * x * x + 2.0 * self.xy * x * y + self.yy * y * y
        return np.asarray(squares - 2.0 * linear + self.square)
