"""The border to patrol: segments joined smoothly by arcs, open or closed, measured by abscissa s.

On a closed border s grows clockwise seen from above, whatever the order of its file, and
differences of s wrap. On an open one s is 0 at the first point, the left end, and the projection
is clamped at both ends. (Patrol CW is +s, the only sense consistent with the paper's eq. 7 and 13.)
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from itertools import pairwise

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray
from shapely import STRtree
from shapely.geometry import LineString

from maps.border_foot import ArcFoot, BorderPoint, SegmentFoot
from maps.border_primitives import Arc, Primitive, Segment
from maps.input_limits import MAX_BORDER_M
from maps.pose import wrap_angle

_GAP_TOLERANCE = 1e-3  # m between the end of a primitive and the start of the next
_KINK_TOLERANCE = 0.02  # rad between their headings
BRANCH_MARGIN = 0.02  # m by which another branch must be nearer to be chosen
BRANCH_REACH = 0.5  # m of abscissa around the previous projection that count as its branch
CELL = 0.5  # m; side of the cells that cache the near pieces
_DRAWING_STEP = 0.02  # m, for the area and the crossing check


class BorderError(ValueError):
    """An invalid border; the message names the primitive and the remedy."""


class BorderProjection(msgspec.Struct, frozen=True):
    """The border's point nearest to a position.

    abscissa, x, y, distance in m; tangent: unit vector along +s; curvature in 1/m, positive where
    +s turns left; side: +1 if the position is left of the tangent (or on it), -1 if right.
    """

    abscissa: float
    x: float
    y: float
    distance: float
    tangent: tuple[float, float]
    curvature: float
    side: int

    @property
    def normal(self) -> tuple[float, float]:
        """Unit vector to the left of the tangent; defined at any distance, also 0."""
        return -self.tangent[1], self.tangent[0]


class Border:
    """An immutable border.

    primitives: segments and arcs in order, each starting where the one before ends, with the same
    heading; of a closed border the last ends where the first starts. A closed border given
    counter-clockwise is reversed; its point s = 0 stays where it was.

    Raises BorderError for gaps, kinks, crossings and empty pieces.
    """

    def __init__(self, primitives: Sequence[Primitive], *, closed: bool) -> None:
        _check_pieces(primitives)
        _check_joints(primitives, closed=closed)
        _check_crossings(primitives, closed=closed)
        if closed and _signed_area(primitives) > 0.0:
            primitives = [primitive.reversed() for primitive in reversed(primitives)]
        self.primitives: tuple[Primitive, ...] = tuple(primitives)
        self.closed = closed
        lengths = [primitive.length for primitive in primitives]
        self.length = math.fsum(lengths)
        self.starts = [math.fsum(lengths[:index]) for index in range(len(lengths))]
        self.feet = tuple(
            SegmentFoot(piece, s) if isinstance(piece, Segment) else ArcFoot(piece, s)
            for piece, s in zip(self.primitives, self.starts, strict=True)
        )
        self._feet_of_cell: dict[tuple[float, float], tuple[SegmentFoot | ArcFoot, ...]] = {}

    @property
    def tightest_radius(self) -> float:
        """Smallest turning radius, m; infinite on a straight border."""
        return min((p.radius for p in self.primitives if isinstance(p, Arc)), default=math.inf)

    def require_radius(self, radius: float) -> None:
        """Raise BorderError, naming the place, if an arc is tighter than a turning radius, m."""
        for index, (primitive, s) in enumerate(zip(self.primitives, self.starts, strict=True)):
            if isinstance(primitive, Arc) and primitive.radius < radius:
                raise BorderError(
                    f"{describe(index, primitive)} at s = {s:.2f} m has the radius "
                    f"{primitive.radius:.2f} m, a robot can follow {radius:g} m and more: widen it"
                )

    def project(self, x: float, y: float, near: float | None = None) -> BorderProjection:
        """Return the border's point nearest to (x, y), m in the map frame.

        near: the previous abscissa. Its branch is kept unless another one is nearer by more than
        0.02 m, so that a position half-way between two stretches does not jump between them.
        """
        distance, s = self.nearest(x, y, near)
        foot_x, foot_y, tx, ty, curvature = self.at(s)
        side = 1 if tx * (y - foot_y) - ty * (x - foot_x) >= 0.0 else -1
        return BorderProjection(s, foot_x, foot_y, distance, (tx, ty), curvature, side)

    def nearest(self, x: float, y: float, near: float | None = None) -> tuple[float, float]:
        """Return only (distance, abscissa), m, of ``project``, which is faster."""
        feet = self.feet_near(x, y)
        if len(feet) == 1:
            distance, s = feet[0].nearest(x, y)
        else:
            distance, s = self._nearest_of(feet, x, y, near)
        if s >= self.length:
            s = 0.0 if self.closed else self.length
        return distance, s

    def _nearest_of(
        self, feet: Sequence[SegmentFoot | ArcFoot], x: float, y: float, near: float | None
    ) -> tuple[float, float]:
        """Return (distance, abscissa), m, of the nearest point of ``feet``, on the branch kept."""
        best_distance, best_s = math.inf, 0.0
        kept_distance, kept_s = math.inf, 0.0
        for foot in feet:
            distance, s = foot.nearest(x, y)
            if distance < best_distance:
                best_distance, best_s = distance, s
            if (
                near is not None
                and distance < kept_distance
                and abs(self.difference(s, near)) <= BRANCH_REACH
            ):
                kept_distance, kept_s = distance, s
        if kept_distance <= best_distance + BRANCH_MARGIN:
            return kept_distance, kept_s
        return best_distance, best_s

    def feet_near(self, x: float, y: float) -> tuple[SegmentFoot | ArcFoot, ...]:
        """Return the pieces that can be nearest to any point in the cell of (x, y).

        Cached by cell: within it a distance differs from the centre's by at most half the diagonal.
        """
        cell = (x // CELL, y // CELL)
        feet = self._feet_of_cell.get(cell)
        if feet is None:
            middle = ((cell[0] + 0.5) * CELL, (cell[1] + 0.5) * CELL)
            distances = [foot.nearest(*middle)[0] for foot in self.feet]
            farthest = min(distances) + math.sqrt(2.0) * CELL + 2.0 * BRANCH_MARGIN
            feet = tuple(
                foot
                for foot, distance in zip(self.feet, distances, strict=True)
                if not distance > farthest  # written so that nan keeps every piece
            )
            self._feet_of_cell[cell] = feet
        return feet

    def project_many(self, points: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return (abscissae (n,), distances (n,)), m, of points (n, 2) in the map frame."""
        xy = np.asarray(points, dtype=np.float64).reshape(-1, 2)
        distances = np.full(len(xy), np.inf)
        abscissae = np.zeros(len(xy))
        for foot in self.feet:
            distance, s = foot.nearest_many(xy)
            nearer = distance < distances
            distances[nearer] = distance[nearer]
            abscissae[nearer] = s[nearer]
        abscissae[abscissae >= self.length] = 0.0 if self.closed else self.length
        return abscissae, distances

    def at(self, s: float) -> BorderPoint:
        """Return the border's point at abscissa s, m: wrapped if closed, clamped if open."""
        s = s % self.length if self.closed else min(max(s, 0.0), self.length)
        index = bisect_right(self.starts, s) - 1
        return self.feet[index].at(s)

    def difference(self, s_to: float, s_from: float) -> float:
        """Return s_to - s_from along the border, m; on a closed one in [-length/2, length/2)."""
        delta = s_to - s_from
        if not self.closed:
            return delta
        half = self.length / 2
        return (delta + half) % self.length - half

    def polyline(self, step: float) -> NDArray[np.float64]:
        """Return (n, 2) points from s = 0 to s = length, evenly spaced by at most ``step`` m.

        Of a closed border the last point repeats the first.
        """
        s = np.linspace(0.0, self.length, math.ceil(self.length / step) + 1)
        piece = np.searchsorted(self.starts, s, side="right") - 1
        points = np.empty((len(s), 2))
        for index, primitive in enumerate(self.primitives):
            mine = piece == index
            points[mine] = primitive.points(s[mine] - self.starts[index])
        return points


def describe(index: int, primitive: Primitive) -> str:
    """Name a primitive in an error message: its number from 1, its kind and its ends."""
    kind = "segment" if isinstance(primitive, Segment) else "arc"
    (x0, y0), (x1, y1) = primitive.start, primitive.end
    return f"primitive {index + 1} ({kind} from {x0:.3f}, {y0:.3f} to {x1:.3f}, {y1:.3f})"


def _check_pieces(primitives: Sequence[Primitive]) -> None:
    if not primitives:
        raise BorderError("a border needs at least one segment or arc")
    for index, primitive in enumerate(primitives):
        if not (math.isfinite(primitive.length) and primitive.length > 0.0):
            raise BorderError(f"{describe(index, primitive)} has no length, remove it")
        if isinstance(primitive, Arc) and abs(primitive.sweep) > math.tau + 1e-9:
            raise BorderError(f"{describe(index, primitive)} goes more than once round its centre")
    length = math.fsum(primitive.length for primitive in primitives)
    if length > MAX_BORDER_M:
        raise BorderError(f"is {length:.0f} m long, more than {MAX_BORDER_M:.0f} m: shorten it")


def _check_joints(primitives: Sequence[Primitive], *, closed: bool) -> None:
    joints = list(pairwise(range(len(primitives))))
    if closed:
        joints.append((len(primitives) - 1, 0))
    for before, after in joints:
        one, next_one = primitives[before], primitives[after]
        gap = math.dist(one.end, next_one.start)
        if gap > _GAP_TOLERANCE:
            raise BorderError(
                f"{describe(before, one)} ends {gap:.3f} m from the start of "
                f"{describe(after, next_one)}, make them meet"
            )
        kink = wrap_angle(next_one.start_heading - one.end_heading)
        if abs(kink) > _KINK_TOLERANCE:
            raise BorderError(
                f"{describe(after, next_one)} turns {math.degrees(kink):.1f} degrees off the end "
                f"of {describe(before, one)}, join them by an arc tangent to both"
            )


def _check_crossings(primitives: Sequence[Primitive], *, closed: bool) -> None:
    """Raise BorderError if the border meets itself; neighbours may meet at their joint only."""
    lines = [LineString(_drawn(primitive)) for primitive in primitives]
    meeting = STRtree(lines).query(lines, predicate="intersects").T
    for one, other in sorted((int(a), int(b)) for a, b in meeting if a < b):
        adjacent = other == one + 1 or (closed and one == 0 and other == len(lines) - 1)
        if not adjacent:
            raise BorderError(
                f"{describe(one, primitives[one])} meets {describe(other, primitives[other])}, "
                "move them apart: a border must not cross or touch itself"
            )


def _signed_area(primitives: Sequence[Primitive]) -> float:
    """Return the enclosed area, m2, positive if the border runs counter-clockwise."""
    x, y = np.concatenate([_drawn(primitive)[:-1] for primitive in primitives]).T
    return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) / 2.0)


def _drawn(primitive: Primitive) -> NDArray[np.float64]:
    """Return points (n, 2) along a primitive, ends included."""
    if isinstance(primitive, Segment):
        return np.array([primitive.start, primitive.end])
    count = math.ceil(primitive.length / _DRAWING_STEP) + 2
    return primitive.points(np.linspace(0.0, primitive.length, count))
