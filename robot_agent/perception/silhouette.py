"""Silhouettes: what a teammate looks like in the plane of another robot's laser.

A laser at 0.2 to 0.4 m above the floor sees the body's rectangle, the body with its corners cut, or
nothing but the housing of a scanner that stands on the deck: that depends on the model and on the
mount. Several are admitted at once; the outline fit chooses the one that explains the points best.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from drivers.lms200.settings import LaserSettings
from drivers.p2os.model import Body

Corners = tuple[tuple[float, float], ...]
"""Corners of a convex polygon, counter-clockwise: x, y, m."""

BODY, CUT_CORNERS, HOUSING = "body", "cut_corners", "housing"
NAMED = (BODY, CUT_CORNERS, HOUSING)
"""Names of silhouettes: the robot's own body, that with its corners cut, a scanner's housing."""
SMALL = 0.30  # m; a narrower silhouette may as well be a leg or a post

_CUT = 0.22  # share of the width cut off along both sides of a corner; ours, after Pioneer drawings
_HOUSING = LaserSettings().housing  # m, depth and width of an LMS 200
_HEADINGS = 36  # in a full turn
_SAME = 0.01  # m; a polygon that deviates less after a part of a turn is symmetric under it
# Widths a segment may have, as shares of a silhouette's narrowest and widest: a scan's beams miss
# parts of the edges, a body is smaller than its bumpers, and it may carry something.
_NARROWEST, _WIDEST = 0.7, 1.13


class SilhouetteError(ValueError):
    """A silhouette is neither a known name nor a convex polygon."""


@dataclass(frozen=True)
class Silhouette:
    """A convex polygon about its middle, m.

    normals: (k, 2) outward unit vectors of its sides; offsets: (k,) their distances from the
    middle, m; corners: (k, 2).
    """

    normals: NDArray[np.float64]
    offsets: NDArray[np.float64]
    corners: NDArray[np.float64]

    @classmethod
    def of(cls, corners: Corners) -> Silhouette:
        """Return the polygon of corners about the middle of the box round it.

        Raises SilhouetteError unless it is convex and counter-clockwise, 0.05 to 2 m in size.
        """
        points = np.array(corners, dtype=np.float64).reshape(-1, 2)
        if len(points) < 3:
            raise SilhouetteError("has fewer than three corners")
        points -= 0.5 * (points.min(axis=0) + points.max(axis=0))
        sides = np.roll(points, -1, axis=0) - points
        following = np.roll(sides, -1, axis=0)
        turns = sides[:, 0] * following[:, 1] - sides[:, 1] * following[:, 0]
        turned = np.arctan2(turns, (sides * following).sum(axis=1)).sum()
        if not (turns > 0.0).all() or turned > 1.5 * math.tau:
            raise SilhouetteError("is not convex with its corners counter-clockwise")
        if not 0.05 <= float(np.ptp(points, axis=0).max()) <= 2.0:
            raise SilhouetteError("is not 0.05 to 2 m in size; corners are in m")
        lengths = np.hypot(sides[:, 0], sides[:, 1])
        normals = np.column_stack((sides[:, 1], -sides[:, 0])) / lengths[:, None]
        return cls(normals, (normals * points).sum(axis=1), points)

    @cached_property
    def headings(self) -> NDArray[np.float64]:
        """Headings (n,), rad, at which it looks different: a part of a turn if symmetric."""
        fold = next((n for n in (4, 2) if self._is_same_after(math.tau / n)), 1)
        count = _HEADINGS // fold
        return np.asarray(np.arange(count) * (math.tau / fold / count), dtype=np.float64)

    def _is_same_after(self, angle: float) -> bool:
        points = _turned(self.corners, angle)
        away = np.hypot(*(points[:, None, :] - self.corners).transpose(2, 0, 1))
        return bool(away.min(axis=1).max() < _SAME)

    @cached_property
    def widths(self) -> NDArray[np.float64]:
        """The widths (_HEADINGS,), m, across a line of sight, by the heading."""
        across = self._reaches()
        return across + np.roll(across, _HEADINGS // 2)

    @cached_property
    def depths(self) -> NDArray[np.float64]:
        """The distances (_HEADINGS,), m, from the nearest point to the middle, by the heading."""
        return np.roll(self._reaches(), _HEADINGS // 4)

    def _reaches(self) -> NDArray[np.float64]:
        """Return (_HEADINGS,) distances, m, of the farthest corner in each direction."""
        angles = np.arange(_HEADINGS) * (math.tau / _HEADINGS)
        directions = np.vstack((np.cos(angles), np.sin(angles)))
        return np.asarray((self.corners @ directions).max(axis=0))

    @property
    def small(self) -> bool:
        """Whether it is so small that a leg or a post looks alike."""
        return float(self.widths.max()) < SMALL

    @cached_property
    def extents(self) -> tuple[float, float]:
        """Least and largest width, m, of a segment that may be all of it."""
        return _NARROWEST * float(self.widths.min()), _WIDEST * float(self.widths.max())

    @cached_property
    def depth_by_width(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Widths (n,) in increasing order with the depths (n,) there, m."""
        order = np.argsort(self.widths, kind="stable")
        return self.widths[order], self.depths[order]


class Silhouettes:
    """The silhouettes that teammates may have, with all their headings in one table each.

    normals: (2, k, n), sides: (k, n) and corners: (2, k, n) of the n hypotheses, a silhouette at a
    heading each, in the frame of the observer; polygons with fewer sides repeat their first.
    owner: (n,) silhouette of each hypothesis.
    """

    def __init__(self, shapes: Sequence[Silhouette], body: Silhouette | None = None) -> None:
        """Take one or more, and the outline of the robot's own body, None for the first shape's.

        Whatever is as wide as the own body is as large as a robot, whether it is admitted or not.
        """
        self.shapes = tuple(shapes)
        self._body_extents = (body or self.shapes[0]).extents
        most = max(len(each.offsets) for each in shapes)
        tables = [_hypotheses(each, most) for each in shapes]
        self.normals = np.concatenate([normals for normals, _, _ in tables], axis=2)
        self.sides = np.concatenate([sides for _, sides, _ in tables], axis=1)
        self.corners = np.concatenate([corners for _, _, corners in tables], axis=2)
        counts = [len(each.headings) for each in shapes]
        self.owner = np.repeat(np.arange(len(shapes)), counts)
        self.weights = np.repeat(1.0 / np.array(counts), counts)
        """(n,) prior of each hypothesis: all silhouettes are as likely, and all headings."""

    @classmethod
    def admitted(
        cls,
        entries: Sequence[str | Corners],
        body: Corners,
        housing: tuple[float, float] = _HOUSING,
    ) -> Silhouettes:
        """Return those of names and polygons; body: corners of the robot's own body, m.

        housing: depth and width of its scanner, m, which its teammates have too.
        Raises SilhouetteError for an unknown name or an unusable polygon.
        """
        chosen = [named(each, body, housing) if isinstance(each, str) else each for each in entries]
        return cls([Silhouette.of(each) for each in chosen], Silhouette.of(body))

    def is_body_sized(self, extent: float) -> bool:
        """Return whether a segment of a width, m, seen whole, may be a robot like this one."""
        narrowest, widest = self._body_extents
        return narrowest <= extent <= widest

    def admitting(self, extent: float) -> NDArray[np.bool_]:
        """Return (silhouettes,) which may be a segment of a width, m, seen whole."""
        low, high = self._extents
        return np.asarray((low <= extent) & (extent <= high))

    @cached_property
    def _extents(self) -> NDArray[np.float64]:
        """(2, silhouettes) least and largest width, m."""
        return np.array([each.extents for each in self.shapes]).T

    @cached_property
    def small(self) -> NDArray[np.bool_]:
        """(silhouettes,) which are small."""
        return np.array([each.small for each in self.shapes])

    @cached_property
    def parts(self) -> NDArray[np.bool_]:
        """(silhouettes,) of which a part may be seen: the large ones, if there are any."""
        return np.ones_like(self.small) if self.small.all() else ~self.small

    @cached_property
    def reach(self) -> float:
        """Distance, m, from the middle to the farthest corner of any."""
        return max(float(np.hypot(*each.corners.T).max()) for each in self.shapes)

    @cached_property
    def narrowest(self) -> float:
        """Least width, m, of a part large enough to be seen whole."""
        return min(each.extents[0] for each in self._chosen(self.parts))

    def depth(self, extent: float) -> float:
        """Return the usual distance, m, from the nearest point to the middle at a width, m."""
        chosen = self._chosen(self.admitting(extent)) or self.shapes
        depths = [float(np.interp(extent, *each.depth_by_width)) for each in chosen]
        return sum(depths) / len(depths)

    def _chosen(self, which: NDArray[np.bool_]) -> list[Silhouette]:
        return [each for each, use in zip(self.shapes, which, strict=True) if use]


def named(name: str, body: Corners, housing: tuple[float, float] = _HOUSING) -> Corners:
    """Return the corners of a named silhouette, m; body: those of the robot's own body.

    housing: depth and width of its scanner, m. Raises SilhouetteError for an unknown name.
    """
    match name:
        case "body":
            return body
        case "cut_corners":
            return _cut(body)
        case "housing":
            return rectangle(*housing)
        case _:
            raise SilhouetteError(f"{name!r} is none of {', '.join(NAMED)}, nor a list of corners")


def rectangle(length: float, width: float) -> Corners:
    """Return the corners of a rectangle about its middle, m."""
    x, y = 0.5 * length, 0.5 * width
    return ((x, -y), (x, y), (-x, y), (-x, -y))


def body_corners(body: Body) -> Corners:
    """Return the corners of a robot model's body, m, about its middle."""
    return rectangle(body.front + body.rear, body.width)


def _cut(body: Corners) -> Corners:
    """Return a polygon with each corner cut by the same length along both sides."""
    length = _CUT * float(np.ptp(np.array(body), axis=0).min())
    cut: list[tuple[float, float]] = []
    for number, (x, y) in enumerate(body):
        for ox, oy in (body[number - 1], body[(number + 1) % len(body)]):
            share = length / math.dist((x, y), (ox, oy))
            cut.append((x + share * (ox - x), y + share * (oy - y)))
    return tuple(cut)


def _hypotheses(
    shape: Silhouette, most: int
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return normals (2, most, n), sides (most, n) and corners (2, most, n) at its n headings."""
    chosen = np.arange(most)
    chosen[len(shape.offsets) :] = 0
    headings = shape.headings
    normals = np.stack([_turned(shape.normals[chosen], angle) for angle in headings], axis=-1)
    corners = np.stack([_turned(shape.corners[chosen], angle) for angle in headings], axis=-1)
    sides = np.repeat(shape.offsets[chosen][:, None], len(headings), axis=1)
    return normals.transpose(1, 0, 2), sides, corners.transpose(1, 0, 2)


def _turned(points: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    c, s = math.cos(angle), math.sin(angle)
    return np.asarray(points @ np.array(((c, s), (-s, c))))
