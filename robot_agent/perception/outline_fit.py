"""A Pioneer's outline laid on the points of segments: where its centre is, how sure, how well.

The outline is a rectangle of unknown heading. For each of a grid of headings the centre that fits
best is found by least squares: every point on the nearest side, and where a beam passes by an edge
of the segment, the outline's edge between that beam and the last one that met it. The centre is
the mean over the headings, each weighted by how well it fits; its covariance holds what points and
headings leave open. All segments of a scan are fitted at once.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

# ARIA's p2dx.p: the body with its bumpers.
HALF_LENGTH, HALF_WIDTH = 0.2555, 0.2125  # m

_HEADINGS = 18  # over half a turn: a rectangle looks the same the other way round
_STEPS = 2  # of the assignment of points to sides
_MOST_POINTS = 20  # of one segment; more tell the same
_POINT_SIGMA = 0.02  # m; range noise, and a body that is no exact rectangle
_FIRST_SIGMA = 0.15  # m; of the centre before the fit, which holds it where nothing else does
_LEAST_VARIANCE = 0.012**2  # m^2; errors that all points of a segment share

_THETA = np.arange(_HEADINGS) * (math.pi / _HEADINGS)
_COS, _SIN = np.cos(_THETA), np.sin(_THETA)
_TO_U = np.column_stack((_COS, _SIN))  # (headings, 2): along the length
_TO_V = np.column_stack((-_SIN, _COS))  # (headings, 2): along the width


@dataclass(frozen=True, slots=True)
class SightEdge:
    """Where a segment ends and the next beam passes by.

    normal_x, normal_y: unit vector in base_link, across the line of sight, out of the segment.
    offset: m along it, half-way between the last beam that met something and the next.
    sigma: m.
    """

    normal_x: float
    normal_y: float
    offset: float
    sigma: float


@dataclass(frozen=True, slots=True)
class OutlineFit:
    """x, y: centre in base_link, m. var_x, var_y, cov_xy: m^2, base_link. misfit: squared
    residuals over their variances, per point and edge, at the best heading; about 0.5 for a
    robot."""

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

    parts: (n, 2) points of each, m, base_link. centres: about where each one's centre is.
    edges: those in sight, none to two of each.
    """
    if not parts:
        return []
    parts = [part[:: math.ceil(len(part) / _MOST_POINTS)] for part in parts]
    counts = np.array([len(part) for part in parts])
    starts = np.concatenate(([0], np.cumsum(counts)[:-1]))
    owner = np.repeat(np.arange(len(parts)), counts)
    points = np.concatenate(parts).T
    u, v = _TO_U @ points, _TO_V @ points  # (headings, points)
    first = np.array(centres).T
    first_u, first_v = _TO_U @ first, _TO_V @ first  # (headings, segments)
    sights = _Edges.of(edges, len(parts))

    centre_u, centre_v = first_u, first_v
    for _ in range(_STEPS):
        off_u, off_v = u - centre_u[:, owner], v - centre_v[:, owner]
        on_end = np.abs(off_u) - HALF_LENGTH > np.abs(off_v) - HALF_WIDTH
        # Where the centre would be by each point: on an end that tells of u, on a side of v.
        by_u = np.where(on_end, u - np.copysign(HALF_LENGTH, off_u), 0.0)
        by_v = np.where(on_end, 0.0, v - np.copysign(HALF_WIDTH, off_v))
        ends = np.add.reduceat(on_end.astype(np.float64), starts, axis=1)
        a, b, c = 1.0 / _FIRST_SIGMA**2, 1.0 / _POINT_SIGMA**2, counts - ends
        uu = a + b * ends + sights.uu
        vv = a + b * c + sights.vv
        uv = sights.uv
        right_u = a * first_u + b * np.add.reduceat(by_u, starts, axis=1) + sights.right_u
        right_v = a * first_v + b * np.add.reduceat(by_v, starts, axis=1) + sights.right_v
        determinant = uu * vv - uv * uv
        centre_u = (vv * right_u - uv * right_v) / determinant
        centre_v = (uu * right_v - uv * right_u) / determinant

    off_u, off_v = u - centre_u[:, owner], v - centre_v[:, owner]
    residuals = np.maximum(np.abs(off_u) - HALF_LENGTH, np.abs(off_v) - HALF_WIDTH)
    chi2 = np.add.reduceat(residuals * residuals, starts, axis=1) / _POINT_SIGMA**2
    chi2 += sights.chi2(centre_u, centre_v)
    best = chi2.min(axis=0)
    weights = np.exp(-0.5 * (chi2 - best))
    weights /= weights.sum(axis=0)
    # Back into base_link; covariances of each heading, and of the headings among themselves.
    cos, sin = _COS[:, None], _SIN[:, None]
    x, y = cos * centre_u - sin * centre_v, sin * centre_u + cos * centre_v
    mean_x, mean_y = (weights * x).sum(axis=0), (weights * y).sum(axis=0)
    var_u, var_v, cov_uv = vv / determinant, uu / determinant, -uv / determinant
    dx, dy = x - mean_x, y - mean_y
    twice = 2.0 * cos * sin * cov_uv
    var_x = cos * cos * var_u + sin * sin * var_v - twice + dx * dx
    var_y = sin * sin * var_u + cos * cos * var_v + twice + dy * dy
    cov_xy = cos * sin * (var_u - var_v) + (cos * cos - sin * sin) * cov_uv + dx * dy
    rows = np.array(
        (
            mean_x,
            mean_y,
            (weights * var_x).sum(axis=0) + _LEAST_VARIANCE,
            (weights * var_y).sum(axis=0) + _LEAST_VARIANCE,
            (weights * cov_xy).sum(axis=0),
            best / (counts + sights.count),
        )
    )
    return [OutlineFit(*row) for row in rows.T.tolist()]


@dataclass(frozen=True, slots=True)
class _Edges:
    """The edges in sight as equations for the centre, at each heading; (headings, segments).

    An edge asks that the outline's farthest corner along its normal be at its offset.
    """

    uu: NDArray[np.float64]
    uv: NDArray[np.float64]
    vv: NDArray[np.float64]
    right_u: NDArray[np.float64]
    right_v: NDArray[np.float64]
    square: NDArray[np.float64]
    count: NDArray[np.float64]
    """(segments,) edges in sight of each."""

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
