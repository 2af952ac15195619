"""Motion of the scanner between two scans, without a map: point-to-line alignment of their points.

Each point of one scan is paired with the nearest surface of the other, and the distances along
the surfaces' normals are minimized (Gauss-Newton, Cauchy weights), after Censi, "An ICP variant
using a point-to-line metric", ICRA 2008. Directions that the surfaces do not determine, as along
a corridor, have no information.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from localization.likelihood_field import spread_evenly
from localization.refinement import as_complex
from maps.pose import Pose, wrap_angle

MAX_POINTS = 60  # of a scan that are paired, spread evenly over it
REACH = 8.0  # m; beams that end farther away are too far apart for surfaces
_SIDE = 4  # neighbours to each side that make a surface
_MAX_GAP = 0.15  # m to the next of the neighbours, at a range of 1 m and per metre beyond
_STRAIGHT = 0.04  # m; a surface's point is no farther from the middle of its neighbours
_PAIRED = (0.5, 0.4, 0.3, 0.2)  # m; maximum distance of a pair in successive steps
_LAST_PAIRED = 0.15  # m; in all later ones
_STEPS = 10
_CONVERGED = 1e-3  # m and rad
_MIN_PAIRS = 15
_SIGMA = 0.02  # m; of a point from the surface: noise and quantization of both scans
_INDEPENDENT = 0.5  # of a pair: neighbours share their surface's error
_ARM = 2.0  # m; typical distance of the points, to compare turning with shifting
_SCALE = np.array((1.0, 1.0, 1.0 / _ARM))
_SCALES = np.outer(_SCALE, _SCALE)
_WEAK = 0.03  # share of the best direction's information; less counts as none


@dataclass(frozen=True, slots=True, eq=False)
class Surfaces:
    """A scan to align others with: (n,) points with known normals, as x + iy, m."""

    points: NDArray[np.complex64]
    normals: NDArray[np.complex64]


@dataclass(frozen=True, slots=True, eq=False)
class ScanMotion:
    """Motion between two scans.

    pose: first_from_second, in the frame of the points. information: (3, 3) inverse covariance of
    its x, y and theta, 1/m2 and 1/rad2; singular where the scans do not determine it. share: of
    the points of the second scan that lie on a surface of the first, 0 to 1.
    """

    pose: Pose
    information: NDArray[np.float64]
    share: float


def surfaces_of(points: NDArray[np.float64]) -> Surfaces | None:
    """Return the surfaces of a scan's points (n, 2), m, in the order of bearing; None: too few."""
    ends = as_complex(points[_near(points)])
    if len(ends) < 2 * _SIDE + _MIN_PAIRS:
        return None
    sums = np.concatenate(([0.0], np.cumsum(ends.astype(np.complex128))))
    middle = np.arange(_SIDE, len(ends) - _SIDE)
    before = (sums[middle] - sums[middle - _SIDE]) / _SIDE
    after = (sums[middle + 1 + _SIDE] - sums[middle + 1]) / _SIDE
    here = ends[middle]
    steps = np.abs(np.diff(ends)) > _MAX_GAP * np.maximum(np.abs(ends[1:]), 1.0)
    gaps = np.concatenate(([0], np.cumsum(steps)))
    whole = gaps[middle + _SIDE] == gaps[middle - _SIDE]
    along = after - before
    normals = 1j * along / np.maximum(np.abs(along), 1e-6)
    off = 0.5 * (before + after) - here
    flat = np.abs((off * normals.conj()).real) < _STRAIGHT
    known = whole & flat
    if np.count_nonzero(known) < _MIN_PAIRS:
        return None
    smooth = (before * _SIDE + after * _SIDE + here) / (2 * _SIDE + 1)
    return Surfaces(smooth[known].astype(np.complex64), normals[known].astype(np.complex64))


def motion_between(first: Surfaces, points: NDArray[np.float64], guess: Pose) -> ScanMotion | None:
    """Return the motion from the scan of the surfaces to that of points (m, 2), m.

    guess: first_from_second. None if too few points have a counterpart.
    """
    ends = as_complex(spread_evenly(points[_near(points)], MAX_POINTS)).astype(np.complex128)
    place, theta = complex(guess.x, guess.y), guess.theta
    for step in range(_STEPS):
        reach = _PAIRED[step] if step < len(_PAIRED) else _LAST_PAIRED
        equations = _linearized(first, ends, place, theta, reach)
        if equations is None:
            return None
        hessian, gradient, _ = equations
        x, y, turn = _change(hessian, gradient).tolist()
        place, theta = place + complex(x, y), theta + turn
        if step >= len(_PAIRED) and max(abs(x), abs(y), abs(turn)) < _CONVERGED:
            break
    equations = _linearized(first, ends, place, theta, _LAST_PAIRED)
    if equations is None:
        return None
    hessian, _, pairs = equations
    information = _observable(hessian) * _INDEPENDENT
    pose = Pose(place.real, place.imag, wrap_angle(theta))
    return ScanMotion(pose, information, pairs / len(ends))


def share_on_surfaces(first: Surfaces, points: NDArray[np.float64], pose: Pose) -> float:
    """Return the share of points (m, 2), m, on the surfaces if first_from_second is pose."""
    ends = as_complex(spread_evenly(points[_near(points)], MAX_POINTS)).astype(np.complex128)
    place = complex(pose.x, pose.y)
    equations = _linearized(first, ends, place, pose.theta, _LAST_PAIRED)
    return 0.0 if equations is None else equations[2] / len(ends)


def _near(points: NDArray[np.float64]) -> NDArray[np.bool_]:
    x, y = points.T
    return np.asarray(x * x + y * y < REACH**2)


def _linearized(
    first: Surfaces, ends: NDArray[np.complex128], place: complex, theta: float, reach: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], int] | None:
    """Return Hessian (3, 3), gradient (3,) of the weighted squares, number of pairs."""
    arms = ends * complex(math.cos(theta), math.sin(theta))
    moved = (arms + place).astype(np.complex64)
    apart = first.points[np.newaxis, :] - moved[:, np.newaxis]
    squares = apart.real**2 + apart.imag**2
    nearest = squares.argmin(axis=1)
    paired = squares[np.arange(len(ends)), nearest] < reach**2
    pairs = int(np.count_nonzero(paired))
    if pairs < _MIN_PAIRS:
        return None
    nearest, arms = nearest[paired], arms[paired]
    normals = first.normals[nearest]
    off = moved[paired] - first.points[nearest]
    residuals = (off * normals.conj()).real / _SIGMA
    lever = normals.imag * arms.real - normals.real * arms.imag
    jacobian = np.array((normals.real, normals.imag, lever), dtype=np.float64) / _SIGMA
    weighted = jacobian / (1.0 + residuals**2 / 4.0)  # Cauchy, at two sigma
    return weighted @ jacobian.T, weighted @ residuals, pairs


def _change(hessian: NDArray[np.float64], gradient: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the Gauss-Newton step (3,), none in the weak directions."""
    values, vectors = np.linalg.eigh(hessian * _SCALES)
    strong = values > _WEAK * values[-1]
    vectors = vectors[:, strong]
    return np.asarray(-_SCALE * (vectors @ ((vectors.T @ (gradient * _SCALE)) / values[strong])))


def _observable(hessian: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a Hessian without its weak directions, which are noise of the normals."""
    values, vectors = np.linalg.eigh(hessian * _SCALES)
    values[values < _WEAK * values[-1]] = 0.0
    return np.asarray((vectors * values) @ vectors.T / _SCALES)
