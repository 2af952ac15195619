"""Learns a teammate's silhouette from a recording in which it turns in place before the robot.

Only what the laser sees is used: the near side of the teammate, from every direction in the course
of its turn. The angle of each scan is found with the silhouette itself, by turns: the points of all
scans, turned back, must lie on one closed curve.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from shapely.geometry import MultiPoint, Polygon

from maps.pose import Pose
from robot_agent.perception.scan_points import move_points
from robot_agent.perception.silhouette import Corners, Silhouette
from tools.calibration.color_calibration import CalibrationError

_REACH = 0.75  # m from its middle to the farthest point of a teammate
_FARTHEST = 2.5  # m of the teammate from the robot
_GAP = 0.12  # m between neighbouring points of one object
_STOOD = (0.03, math.radians(1.5))  # m, rad; motion by which the robot counts as standing
_LEAST_SCANS = 40
_BINS = 72  # of the curve, by direction
_COVERED = 0.95  # share of the directions that must have been seen
_KNOT_S = 2.0  # s between the knots of the turning angle
_RATES = np.concatenate((np.arange(-1.5, -0.095, 0.02), np.arange(0.1, 1.505, 0.02)))  # rad/s
_ROUNDS = 8
_OUTLIER = 0.02  # m
_TOLERANCE = 0.012  # m by which the polygon may leave out a corner


@dataclass(frozen=True, slots=True)
class StandingScan:
    """A scan of a robot that stands. points: (n, 2), m, in a frame that stands too."""

    t: float
    points: NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class LearnedSilhouette:
    """A teammate's silhouette. corners: m, about the axle, at an arbitrary heading.

    points: (n, 2) of all scans, m, in its frame. rms: m, of their distances from the polygon;
    before: the same from the best of the silhouettes admitted so far. turned: rad.
    """

    corners: Corners
    points: NDArray[np.float64]
    rms: float
    before: float
    turned: float


def standing_scans(
    scans: Sequence[tuple[float, Pose, NDArray[np.float64]]],
) -> list[StandingScan]:
    """Return the longest part of a recording in which the robot stands.

    scans: time, s, odom_from_base, and points (n, 2), m, base_link, ordered by bearing.
    """
    best: list[StandingScan] = []
    current: list[StandingScan] = []
    place: Pose | None = None
    for t, odometry, points in scans:
        if place is None or _has_left(place, odometry):
            current, place = [], odometry
        current.append(StandingScan(t, move_points(points, place.between(odometry))))
        if len(current) > len(best):
            best = current
    return best


def _has_left(place: Pose, now: Pose) -> bool:
    moved = place.between(now)
    return math.hypot(moved.x, moved.y) > _STOOD[0] or abs(moved.theta) > _STOOD[1]


def learn_silhouette(
    scans: Sequence[StandingScan], admitted: Sequence[Silhouette] = ()
) -> LearnedSilhouette:
    """Learn the silhouette of the nearest object, which turns in place.

    admitted: those so far. Raises CalibrationError if there are too few scans, nothing near, or if
    it was not seen from all sides.
    """
    if len(scans) < _LEAST_SCANS:
        raise CalibrationError(
            f"the robot stood for {len(scans)} scans, {_LEAST_SCANS} are needed: let it stand, and "
            "turn the teammate in place before it once round"
        )
    parts = _object_in(scans)
    times = np.concatenate([np.full(len(part), scan.t) for scan, part in parts]) - scans[0].t
    points = np.concatenate([part for _, part in parts])
    turn = _Turn(times)
    centre, rate = _first_guess(turn, points)
    parameters = np.concatenate((centre, rate * turn.knots))
    for _ in range(_ROUNDS):
        parameters = _improved(parameters, turn, points)
    own = turn.turned_back(parameters, points)
    curve = _curve(own)
    turned = float(np.ptp(parameters[2:]))
    seen = float(np.isfinite(curve).mean())
    if seen < _COVERED or turned < math.tau:
        raise CalibrationError(
            f"the teammate turned {math.degrees(turned):.0f} degrees, and {100 * seen:.0f} % of it "
            "was seen: turn it in place once round or more, at a steady rate"
        )
    corners = _polygon(curve)
    shape = Silhouette.of(corners)
    near = own[np.abs(np.hypot(*own.T) - _at(curve, own)) < 3.0 * _OUTLIER]
    return LearnedSilhouette(
        corners=corners,
        points=own,
        rms=_rms(shape, near - _middle(corners)),
        before=min(
            (_best_rms(each, near - _middle(corners)) for each in admitted), default=math.nan
        ),
        turned=turned,
    )


def _object_in(
    scans: Sequence[StandingScan],
) -> list[tuple[StandingScan, NDArray[np.float64]]]:
    """Return the scans with their points on the object, which stays at one place."""
    firsts = [part for scan in scans[:10] if (part := _nearest(scan.points)) is not None]
    if not firsts:
        raise CalibrationError(
            f"nothing stands within {_FARTHEST:g} m: let the teammate stand 0.8 to 2 m before the "
            "robot, with 0.8 m of free floor round it"
        )
    middle = np.median(np.concatenate(firsts), axis=0)
    middle = middle * (1.0 + 0.15 / math.hypot(*middle))  # its near side was seen
    found = [(scan, scan.points[np.hypot(*(scan.points - middle).T) < _REACH]) for scan in scans]
    return [(scan, part) for scan, part in found if len(part) >= 3]


def _nearest(points: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Return the nearest object's points of a scan; None without any in reach."""
    steps = np.hypot(*np.diff(points, axis=0).T)
    parts = [part for part in np.split(points, np.flatnonzero(steps > _GAP) + 1) if len(part) >= 3]
    near = [(float(np.hypot(*part.T).min()), part) for part in parts]
    distance, part = min(near, key=lambda each: each[0], default=(math.inf, points))
    return part if distance < _FARTHEST else None


class _Turn:
    """The turning angle of every point as a line through knots, rad.

    Parameters are x, y of the axis, m, and the angle at each knot.
    """

    def __init__(self, times: NDArray[np.float64]) -> None:
        count = max(math.ceil(float(times.max()) / _KNOT_S), 1) + 1
        self.knots = np.linspace(0.0, float(times.max()), count)
        self._times = times

    def turned_back(
        self, parameters: NDArray[np.float64], points: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return points (n, 2) in the frame of the teammate."""
        angle = np.interp(self._times, self.knots, parameters[2:])
        x, y = (points - parameters[:2]).T
        c, s = np.cos(angle), np.sin(angle)
        return np.column_stack((c * x + s * y, c * y - s * x))


def _first_guess(turn: _Turn, points: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Return the axis, m, and the steady rate, rad/s, that give the thinnest curve."""
    axis = _swept_circle(points)
    rates = {float(rate): _thickness(turn, points, axis, float(rate)) for rate in _RATES}
    return axis, min(rates, key=lambda rate: rates[rate])


def _swept_circle(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the middle of the circle that a turning body sweeps: its edges and its near side."""
    middle = points.mean(axis=0)
    ahead = middle / math.hypot(*middle)
    across = points @ np.array((-ahead[1], ahead[0]))
    low, high = np.percentile(across, (0.5, 99.5))
    near = float(np.percentile(points @ ahead, 0.5))
    reach = 0.5 * (high - low)
    return np.asarray((near + reach) * ahead + 0.5 * (low + high) * np.array((-ahead[1], ahead[0])))


def _thickness(
    turn: _Turn, points: NDArray[np.float64], axis: NDArray[np.float64], rate: float
) -> float:
    own = turn.turned_back(np.concatenate((axis, rate * turn.knots)), points)
    off = np.abs(np.hypot(*own.T) - _at(_curve(own), own))
    return float(np.minimum(off, 3.0 * _OUTLIER).mean())


def _curve(own: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the median distance (_BINS,) from the axis by direction, m; NaN where unseen."""
    which = _bin_of(own)
    distance = np.hypot(*own.T)
    order = np.lexsort((distance, which))
    counts = np.bincount(which, minlength=_BINS)
    ends = np.cumsum(counts)
    middle = np.clip(ends - counts + counts // 2, 0, len(own) - 1)
    return np.where(counts >= 3, distance[order[middle]], np.nan)


def _bin_of(own: NDArray[np.float64]) -> NDArray[np.intp]:
    share = np.arctan2(own[:, 1], own[:, 0]) / math.tau % 1.0
    return np.asarray(np.minimum(share * _BINS, _BINS - 1).astype(np.intp))


def _at(curve: NDArray[np.float64], own: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the curve's distance, m, in the directions of points; the mean where it is unknown."""
    known = np.where(np.isfinite(curve), curve, np.nanmean(curve))
    middles = (np.arange(_BINS) + 0.5) * (math.tau / _BINS)
    angles = np.arctan2(own[:, 1], own[:, 0]) % math.tau
    return np.asarray(np.interp(angles, middles, known, period=math.tau))


def _improved(
    parameters: NDArray[np.float64], turn: _Turn, points: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return axis and angles fitted to the present curve; the first angle stays."""
    curve = _curve(turn.turned_back(parameters, points))

    def residuals(free: NDArray[np.float64]) -> NDArray[np.float64]:
        trial = np.concatenate((free[:2], parameters[2:3], free[2:]))
        own = turn.turned_back(trial, points)
        return np.asarray(np.hypot(*own.T) - _at(curve, own))

    start = np.concatenate((parameters[:2], parameters[3:]))
    found = least_squares(residuals, start, loss="soft_l1", f_scale=_OUTLIER, max_nfev=8)
    return np.concatenate((found.x[:2], parameters[2:3], found.x[2:]))


def _polygon(curve: NDArray[np.float64]) -> Corners:
    """Return the convex polygon of a curve with few corners, counter-clockwise, m."""
    known = np.flatnonzero(np.isfinite(curve))
    angles = (known + 0.5) * (math.tau / _BINS)
    hull = MultiPoint(
        np.column_stack((np.cos(angles), np.sin(angles))) * curve[known, None]
    ).convex_hull
    simpler = hull.simplify(_TOLERANCE).convex_hull
    assert isinstance(simpler, Polygon), "seen from all sides"
    outline = np.array(simpler.exterior.coords)[:-1]
    x, y = outline.T
    area = float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())
    ordered = outline if area > 0.0 else outline[::-1]
    return tuple((round(x, 3), round(y, 3)) for x, y in ordered.tolist())


def _middle(corners: Corners) -> NDArray[np.float64]:
    points = np.array(corners)
    return np.asarray(0.5 * (points.min(axis=0) + points.max(axis=0)))


def _rms(shape: Silhouette, points: NDArray[np.float64]) -> float:
    """Return the root mean square distance, m, of points (n, 2) from a polygon's sides."""
    off = (points @ shape.normals.T - shape.offsets).max(axis=1)
    return math.sqrt(float((off * off).mean()))


def _best_rms(shape: Silhouette, points: NDArray[np.float64]) -> float:
    """Return the smallest rms over the headings."""
    angles = np.arange(72) * (math.tau / 72)
    return min(_rms(shape, move_points(points, Pose(0.0, 0.0, angle))) for angle in angles.tolist())
