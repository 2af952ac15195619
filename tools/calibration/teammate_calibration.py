"""Learns a teammate's silhouette from a recording in which it turns in place before the robot.

Only what the laser sees is used: the near side of the teammate, from every direction in the course
of its turn. The angle of each scan is found with the silhouette itself, by turns: the points of all
scans, turned back, must lie on one closed curve.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

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
_HALF_DEPTH = 0.15  # m from the points seen of a thing to its middle, about
_FIRST_SCANS = 10  # in which it is looked for
_PRESENT = 0.8  # share of the scans in which it must be seen
_GAP = 0.12  # m between neighbouring points of one object
_STOOD = (0.03, math.radians(1.5))  # m, rad; motion by which the robot counts as standing
_LEAST_SCANS = 40
_BINS = 72  # of the curve, by direction
_LEAST_TURN = math.radians(330.0)  # between the first and the last change of the view
_COVERED = 0.95  # share of the directions that must have been seen
_MOST_POINTS = 3000  # used of a recording; more add little
_KNOT_S = 2.0  # s between the knots of the turning angle
_SLOWEST, _FASTEST = 0.1, 1.5  # rad/s
_PHASE = 0.3  # rad by which the steadiest turn may be off at its end
_BLOCK_S = 1.0  # s over which a view is averaged to tell a turn from a rest
_CHANGES = 0.004  # m of the view from block to block in a turn; 0.001 to 0.002 m at rest
_ROUNDS = 8
_OUTLIER = 0.02  # m
_TOLERANCE = 0.012  # m by which the polygon may leave out a corner


@dataclass(frozen=True, slots=True)
class StandingScan:
    """A scan of a robot that stands. points: (n, 2), m, in a frame that stands too."""

    t: float
    points: NDArray[np.float64]


Parts = list[tuple[StandingScan, NDArray[np.float64]]]
"""Scans with their points (n, 2) on one object, m."""


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
    """Learn the silhouette of the object that turns in place before the robot.

    admitted: those so far. Raises CalibrationError if there are too few scans, nothing near, or if
    it was not seen from all sides.
    """
    if len(scans) < _LEAST_SCANS:
        raise CalibrationError(
            f"the robot stood for {len(scans)} scans, {_LEAST_SCANS} are needed: let it stand, and "
            "turn the teammate in place before it once round"
        )
    guess = min(map(_guess_of, _turning_things(scans)), key=lambda each: each.thickness)
    turn, points, parameters = guess.turn, guess.points, guess.parameters
    for _ in range(_ROUNDS):
        parameters = _improved(parameters, turn, points)
    own = turn.turned_back(parameters, points)
    curve = _curve(own)
    turned = float(np.ptp(parameters[2:]))
    seen = float(np.isfinite(curve).mean())
    if seen < _COVERED or turned < _LEAST_TURN:
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


def _turning_things(scans: Sequence[StandingScan]) -> list[Parts]:
    """Return the scans of each thing that stands alone, while its view changes.

    Raises CalibrationError without any.
    """
    near = [_points_near(scans, middle) for middle in _places(scans)]
    alone = [parts for parts in near if len(parts) > _PRESENT * len(scans)]
    if not alone:
        raise CalibrationError(
            f"nothing stands alone within {_FARTHEST:g} m: let the teammate stand 0.8 to 2 m "
            "before the robot, with 0.8 m of free floor round it"
        )
    turning = [parts for each in alone if len(parts := _turning(each)) >= _LEAST_SCANS]
    if not turning:
        raise CalibrationError("nothing turns before the robot: turn the teammate in place")
    return turning


def _places(scans: Sequence[StandingScan]) -> list[NDArray[np.float64]]:
    """Return the middles (2,), m, of the things in the first scans that stand alone."""
    places: list[NDArray[np.float64]] = []
    for scan in scans[:_FIRST_SCANS]:
        for part in _alone(scan.points):
            middle = part.mean(axis=0)
            middle = middle * (1.0 + _HALF_DEPTH / math.hypot(*middle))  # its near side was seen
            if all(math.dist(middle, place) > _REACH / 2 for place in places):
                places.append(middle)
    return places


def _alone(points: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Return the points of each thing of a scan as large as a robot or smaller, in reach."""
    steps = np.hypot(*np.diff(points, axis=0).T)
    parts = np.split(points, np.flatnonzero(steps > _GAP) + 1)[1:-1]
    return [
        part
        for part in parts
        if len(part) >= 3
        and math.dist(part[0], part[-1]) < 1.5 * _REACH
        and float(np.hypot(*part.T).min()) < _FARTHEST
    ]


def _points_near(scans: Sequence[StandingScan], middle: NDArray[np.float64]) -> Parts:
    """Return the scans in which one thing, and one that stands alone, is at a place."""
    near = [
        (scan, [part for part in _alone(scan.points) if _is_at(part, middle)]) for scan in scans
    ]
    return [(scan, parts[0]) for scan, parts in near if len(parts) == 1]


def _is_at(part: NDArray[np.float64], middle: NDArray[np.float64]) -> bool:
    return bool(np.hypot(*(part - middle).T).max() < _REACH)


def _turning(parts: Parts) -> Parts:
    """Return the scans between the first and the last change of the view; empty without one."""
    views = _views(parts)
    blocks = sorted(views)
    steps = np.diff([views[block] for block in blocks], axis=0)
    changed = np.flatnonzero(np.abs(steps).max(axis=1) > _CHANGES)
    if not len(changed):
        return []
    first, last = blocks[changed[0] + 1], blocks[changed[-1]]
    return [(scan, part) for scan, part in parts if first <= _block_of(parts, scan) <= last]


def _views(parts: Parts) -> dict[int, NDArray[np.float64]]:
    """Return the median view (3,) in each block of time."""
    blocks: dict[int, list[NDArray[np.float64]]] = {}
    for scan, part in parts:
        blocks.setdefault(_block_of(parts, scan), []).append(_view(part))
    return {block: np.median(views, axis=0) for block, views in blocks.items()}


def _block_of(parts: Parts, scan: StandingScan) -> int:
    return int((scan.t - parts[0][0].t) / _BLOCK_S)


def _view(part: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return an object's nearest distance and its edges across the line of sight, m."""
    ahead = part.mean(axis=0)
    ahead = ahead / math.hypot(*ahead)
    across = part @ np.array((-ahead[1], ahead[0]))
    near = np.sort(part @ ahead)[: max(len(part) // 3, 1)].mean()
    return np.array((near, across.min(), across.max()))


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


class _Guess(NamedTuple):
    """A steady turn: axis and angles as ``_Turn`` has them, and how thick the curve then is, m."""

    turn: _Turn
    points: NDArray[np.float64]
    parameters: NDArray[np.float64]
    thickness: float


def _guess_of(parts: Parts) -> _Guess:
    """Return the steady rate of a thing's turn that gives the thinnest curve."""
    times = np.concatenate([np.full(len(part), scan.t) for scan, part in parts])
    points = np.concatenate([part for _, part in parts])
    thinned = slice(None, None, math.ceil(len(points) / _MOST_POINTS))
    points, turn = points[thinned], _Turn(times[thinned] - times[0])
    axis = _swept_circle(points)
    steps = math.ceil((_FASTEST - _SLOWEST) * turn.knots[-1] / _PHASE) + 1
    left = np.linspace(_SLOWEST, _FASTEST, steps)
    trials = [np.concatenate((axis, rate * turn.knots)) for rate in (*left, *-left)]
    thickness = [_thickness(turn, points, trial) for trial in trials]
    best = int(np.argmin(thickness))
    return _Guess(turn, points, trials[best], thickness[best])


def _swept_circle(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the middle of the circle that a turning body sweeps: its edges and its near side."""
    middle = points.mean(axis=0)
    ahead = middle / math.hypot(*middle)
    across = points @ np.array((-ahead[1], ahead[0]))
    low, high = np.percentile(across, (0.5, 99.5))
    near = float(np.percentile(points @ ahead, 0.5))
    reach = 0.5 * (high - low)
    return np.asarray((near + reach) * ahead + 0.5 * (low + high) * np.array((-ahead[1], ahead[0])))


def _thickness(turn: _Turn, points: NDArray[np.float64], parameters: NDArray[np.float64]) -> float:
    own = turn.turned_back(parameters, points)
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
    angles = np.arange(360) * (math.tau / 360)
    return min(_rms(shape, move_points(points, Pose(0.0, 0.0, angle))) for angle in angles.tolist())
