"""Segments: runs of neighbouring unexplained points, sized against the teammates' silhouettes.

A body's rectangle of 0.511 x 0.425 m measures 0.38 to 0.67 m across the line of sight, a scanner's
housing 0.16 to 0.22 m. The centre lies behind the nearest point by half the depth, which follows
from the width seen: end-on or sideways it is narrow and shallow, seen across a corner wide and
deep. Other segments are persons or objects; two legs are one person. A leg alone may look like a
housing; with a second one beside it, it is a leg.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum, auto
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from robot_agent.perception.outline_fit import OutlineFit, SightEdge, fit_outlines
from robot_agent.perception.silhouette import Silhouettes

# Dimensions of objects in the plane of the laser, across the line of sight.
SEGMENT_GAP = 0.10  # m between neighbouring points of one object, close up
MIN_PARTIAL_EXTENT = 0.12  # m, an edge hidden by something nearer or out of view
MAX_STRANGER_EXTENT = 1.1  # m; larger objects are furniture
MIN_PERSON_EXTENT = 0.22  # m; smaller ones are legs, two to a person
STRIDE = 0.55  # m between two legs of one person
MEAN_HALF_WIDTH = 0.27  # m from the centre to an edge, mean over headings
_MIN_POINTS = 3
_DEEPEST = 0.325  # m from the nearest point to the middle of an object that is no robot
_LEG = 0.05  # m; less is a chair's leg or noise
_LEG_SIGMA = 0.12  # m; of a person's centre by the legs, one of which stands still
_THIN = 0.75  # m; wider segments are objects of their own
_BESIDE = 0.45  # m from the middle of a robot within which thin segments are parts of it
_TAPE_REACH = 0.45  # m from a robot's middle to tape round it
_TAPE = 0.5  # share of the beams on a robot that tape returns; metal does near its normal alone
_MIN_FILL = 0.6  # share of the beams a solid object of this width would return
_MAX_SEGMENTS = 6  # nearest ones kept: bounds the tracker's load by a scan that fits no map
_COARSEST_INCREMENT = math.radians(1.0)
_FINEST_INCREMENT = math.radians(0.25)
_EDGE_SIGMA = 0.01  # m; of an edge, in addition to the beams' spacing
_SMALL_FITS = 1.0  # misfit up to which a small segment may be a small silhouette
_GRAZED = 0.55  # m between neighbouring points on a robot's side seen along it, at most
_OCCLUDER_STEP = 0.15  # m by which a neighbouring beam must be nearer to hide an edge


class Edge(Enum):
    """How a segment ends, towards the next beam."""

    CLEAR = auto()  # the next beam passes and hits something farther away
    HIDDEN = auto()  # the next beam hits something nearer, or there is no next beam
    JOINED = auto()  # the surface continues in points that the map explains


@dataclass(frozen=True, slots=True)
class Segment:
    """A robot, a person or an object in one scan.

    x, y: estimated centre in base_link, m. extent: width seen across the line of sight, m.
    var_x, var_y, cov_xy: of the centre, m^2, base_link. points: number of beams that hit it.
    whole: enough of it is seen to measure its size; otherwise it is a part that may belong to a
    track. robot_sized: it may be a robot by its size. small: its silhouette would be one that a leg
    or a post has too. misfit: of the best silhouette (``OutlineFit``), infinite without a fit.
    reflecting: it wears reflecting tape, if the laser reports that. legs: it is a pair of them.
    """

    x: float
    y: float
    extent: float
    var_x: float
    var_y: float
    cov_xy: float
    points: int
    whole: bool
    robot_sized: bool = True
    small: bool = False
    misfit: float = math.inf
    reflecting: bool = False
    legs: bool = False


@dataclass(frozen=True, slots=True)
class _Run:
    """Neighbouring points first..last, as a segment before any fit, with its visible edges.

    admitted: (silhouettes,) which it may be; None if it is too small or too large for all.
    """

    first: int
    last: int
    edges: tuple[SightEdge, ...]
    segment: Segment
    admitted: NDArray[np.bool_] | None


def find_segments(
    silhouettes: Silhouettes,
    points: NDArray[np.float64],
    ranges: NDArray[np.float64],
    unexplained: NDArray[np.bool_],
    reflectors: NDArray[np.bool_] | None = None,
) -> list[Segment]:
    """Return the segments of a scan that may be a robot or a person, nearest first.

    silhouettes: those that robots may have. points: (n, 2) base_link, ordered by bearing,
    counter-clockwise; ranges: (n,) their distances, m; unexplained: (n,) which of them the map does
    not explain; reflectors: (n,) which are of a reflector, None if the laser does not report them.
    At most _MAX_SEGMENTS are returned.
    """
    indices = np.flatnonzero(unexplained)
    if len(indices) < _MIN_POINTS:
        return []
    increment = _angular_increment(points)
    firsts, lasts = _runs(points, ranges, indices, increment)
    runs = [
        run
        for first, last in zip(firsts.tolist(), lasts.tolist(), strict=True)
        if last - first + 1 >= _MIN_POINTS
        and (run := _run(silhouettes, points, ranges, first, last, increment)) is not None
    ]
    segments = [each.segment for each in runs if each.admitted is None]
    segments += _fitted(silhouettes, points, [each for each in runs if each.admitted is not None])
    if reflectors is not None and reflectors.any():
        beams = points[indices], reflectors[indices]
        segments = [_with_tape(segment, *beams) for segment in segments]
    segments = _people(segments)
    segments.sort(key=_distance)
    return segments[:_MAX_SEGMENTS]


def _fitted(
    silhouettes: Silhouettes, points: NDArray[np.float64], runs: list[_Run]
) -> list[Segment]:
    """Return the segments of runs that may be robots, with centre and misfit of the best fit.

    A small one that no silhouette fits stays as it was: a leg or a post.
    """
    if not runs:
        return []
    fits = fit_outlines(
        silhouettes,
        [points[each.first : each.last + 1] for each in runs],
        [(each.segment.x, each.segment.y) for each in runs],
        [each.edges for each in runs],
        np.array([each.admitted for each in runs]),
    )
    return [
        _as_fitted(run.segment, fit, small=bool(silhouettes.small[fit.silhouette]))
        for run, fit in zip(runs, fits, strict=True)
    ]


def _as_fitted(segment: Segment, fit: OutlineFit, *, small: bool) -> Segment:
    if small and fit.misfit > _SMALL_FITS:
        return replace(segment, robot_sized=False)
    return replace(
        segment,
        x=fit.x,
        y=fit.y,
        var_x=fit.var_x,
        var_y=fit.var_y,
        cov_xy=fit.cov_xy,
        small=small,
        misfit=fit.misfit,
    )


def _distance(segment: Segment) -> float:
    return math.hypot(segment.x, segment.y)


def _with_tape(
    segment: Segment, points: NDArray[np.float64], reflectors: NDArray[np.bool_]
) -> Segment:
    """Return the segment with whether it wears tape; points: those that the map does not explain.

    A glint of metal on it, or of a wall beside it, is no tape.
    """
    away = np.hypot(points[:, 0] - segment.x, points[:, 1] - segment.y)
    on_it = reflectors[away < _TAPE_REACH]
    return replace(segment, reflecting=bool(on_it.any()) and float(on_it.mean()) >= _TAPE)


def _people(segments: list[Segment]) -> list[Segment]:
    """Return the segments with legs paired: two within a stride are a person, one is a part.

    Thin segments beside one as large as a robot are parts of that and dropped. A small silhouette
    without a leg beside it may be a robot.
    """
    robots = [each for each in segments if each.whole and each.robot_sized and not each.small]
    segments = robots + [
        each
        for each in segments
        if each not in robots
        and (each.extent > _THIN or all(_apart(each, robot) > _BESIDE for robot in robots))
    ]
    legs = [
        each
        for each in segments
        if each.whole and (each.small or (each.extent < MIN_PERSON_EXTENT and not each.robot_sized))
    ]
    found = [each for each in segments if each not in legs]
    within_a_stride = [pair for pair in combinations(legs, 2) if _apart(*pair) <= STRIDE]
    # The closest first: a housing beside a person is not the second leg of the nearer one.
    for one, other in sorted(within_a_stride, key=lambda pair: _apart(*pair)):
        if one in legs and other in legs:
            legs = [each for each in legs if each not in (one, other)]
            found.append(_person(one, other))
    return found + [replace(leg, whole=leg.small) for leg in legs]


def _apart(a: Segment, b: Segment) -> float:
    return math.hypot(a.x - b.x, a.y - b.y)


def _person(a: Segment, b: Segment) -> Segment:
    return Segment(
        x=(a.x + b.x) / 2,
        y=(a.y + b.y) / 2,
        extent=_apart(a, b) + (a.extent + b.extent) / 2,
        var_x=_LEG_SIGMA**2,
        var_y=_LEG_SIGMA**2,
        cov_xy=0.0,
        points=a.points + b.points,
        whole=True,
        robot_sized=False,
        reflecting=a.reflecting or b.reflecting,
        legs=True,
    )


def _angular_increment(points: NDArray[np.float64]) -> float:
    """Return the angle between neighbouring beams, rad: the median, as some have no return."""
    steps = np.diff(np.arctan2(points[:, 1], points[:, 0]))
    middle = len(steps) // 2
    median = float(np.partition(steps, middle)[middle])
    return min(max(median, _FINEST_INCREMENT), _COARSEST_INCREMENT)


def _runs(
    points: NDArray[np.float64],
    ranges: NDArray[np.float64],
    indices: NDArray[np.intp],
    increment: float,
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return first and last index of each run of neighbouring points without a gap."""
    steps = np.diff(points[indices], axis=0)
    gaps = np.hypot(steps[:, 0], steps[:, 1])
    # The beams' spacing grows with range: the gap allowed covers one missing return.
    allowed = np.maximum(SEGMENT_GAP, 2.5 * increment * ranges[indices[1:]])
    breaks = np.flatnonzero((np.diff(indices) > 1) | (gaps > allowed))
    firsts = indices[np.concatenate(([0], breaks + 1))]
    lasts = indices[np.concatenate((breaks, [len(indices) - 1]))]
    return firsts, lasts


def _run(
    silhouettes: Silhouettes,
    points: NDArray[np.float64],
    ranges: NDArray[np.float64],
    first: int,
    last: int,
    increment: float,
) -> _Run | None:
    """Return the run of points first..last if it may be a robot or a person, else None."""
    right = _edge(points, ranges, first, -1, increment)
    left = _edge(points, ranges, last, +1, increment)
    if right is Edge.JOINED and left is Edge.JOINED:
        return None  # a bulge of a known surface

    # Axes along and across the line of sight to the middle of the run.
    sight = points[first] / ranges[first] + points[last] / ranges[last]
    sight /= math.hypot(sight[0], sight[1])
    ux, uy = float(sight[0]), float(sight[1])
    part = points[first : last + 1]
    along = part @ sight
    across = part @ np.array((-uy, ux))
    near = float(along.min())
    beam_spacing = increment * near
    # Each edge lies between its last beam and the next one.
    rightmost = float(across.min()) - beam_spacing / 2
    leftmost = float(across.max()) + beam_spacing / 2
    extent = leftmost - rightmost

    count = last - first + 1
    partial = Edge.HIDDEN in (right, left)
    clear = right is Edge.CLEAR and left is Edge.CLEAR
    admitted = _admitted(silhouettes, extent, partial=partial, clear=clear)
    if admitted is None and (partial or not (clear and _LEG <= extent <= MAX_STRANGER_EXTENT)):
        return None
    span = _angle_between(points[first], points[last])
    if count < _MIN_FILL * (1.0 + span / increment):
        return None

    if admitted is not None:
        distance = near + silhouettes.depth(extent)
    else:
        distance = near + min(0.4 * extent, _DEEPEST)
    offset, sigma_across = _across(right, left, rightmost, leftmost)
    along_variance, across_variance = (0.08 if partial else 0.05) ** 2, sigma_across**2
    segment = Segment(
        x=distance * ux - offset * uy,
        y=distance * uy + offset * ux,
        extent=extent,
        var_x=ux * ux * along_variance + uy * uy * across_variance,
        var_y=uy * uy * along_variance + ux * ux * across_variance,
        cov_xy=ux * uy * (along_variance - across_variance),
        points=count,
        whole=not partial or extent >= silhouettes.narrowest,
        robot_sized=admitted is not None or silhouettes.is_body_sized(extent),
    )
    edges = tuple(
        _sight_edge(points[index], ranges[index], side, increment)
        for edge, index, side in ((right, first, -1), (left, last, 1))
        if edge is Edge.CLEAR and _passes(points, index, side)
    )
    return _Run(first, last, edges, segment, admitted)


def _admitted(
    silhouettes: Silhouettes, extent: float, *, partial: bool, clear: bool
) -> NDArray[np.bool_] | None:
    """Return (silhouettes,) which a run of a width, m, may be, None for none.

    partial: an edge is hidden; then it may be a part of the large ones. clear: neither edge is
    hidden or joined to a surface; a small silhouette must be seen so.
    """
    whole = silhouettes.admitting(extent)
    if not clear:
        whole &= silhouettes.parts
    if whole.any():
        return whole
    if partial and MIN_PARTIAL_EXTENT <= extent < silhouettes.narrowest:
        return silhouettes.parts
    return None


def _passes(points: NDArray[np.float64], index: int, side: int) -> bool:
    """Return whether the beam beside the last of a run passes a robot rather than grazes it."""
    dx, dy = (points[index + side] - points[index]).tolist()
    return math.hypot(dx, dy) > _GRAZED


def _sight_edge(
    point: NDArray[np.float64], distance: float, side: int, increment: float
) -> SightEdge:
    """Return the edge beyond the last point of a run; side: 1 to its left, -1 to its right."""
    half_spacing = 0.5 * increment * float(distance)
    x, y = point.tolist()
    return SightEdge(
        normal_x=-side * y / distance,
        normal_y=side * x / distance,
        offset=half_spacing,
        sigma=math.hypot(half_spacing / math.sqrt(3.0), _EDGE_SIGMA),
    )


def _angle_between(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """Return the angle from vector a to vector b, rad."""
    return math.atan2(a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1])


def _edge(
    points: NDArray[np.float64],
    ranges: NDArray[np.float64],
    index: int,
    step: int,
    increment: float,
) -> Edge:
    """Return the kind of edge of the run that ends at ``index``, towards index + step (+1, -1)."""
    neighbour = index + step
    if not 0 <= neighbour < len(points):
        return Edge.HIDDEN
    dx, dy = points[neighbour] - points[index]
    if math.hypot(dx, dy) <= max(SEGMENT_GAP, 2.5 * increment * ranges[index]):
        return Edge.JOINED
    if ranges[neighbour] < ranges[index] - _OCCLUDER_STEP:
        return Edge.HIDDEN
    return Edge.CLEAR


def _across(right: Edge, left: Edge, rightmost: float, leftmost: float) -> tuple[float, float]:
    """Return the centre's offset to the left of the line of sight, m, and its sigma."""
    if right is Edge.CLEAR and left is Edge.CLEAR:
        return 0.0, 0.03
    half_seen = (leftmost - rightmost) / 2
    missing = max(MEAN_HALF_WIDTH - half_seen, 0.0)
    if right is Edge.CLEAR:
        return missing, 0.05 + missing / 2
    if left is Edge.CLEAR:
        return -missing, 0.05 + missing / 2
    return 0.0, 0.05 + missing
