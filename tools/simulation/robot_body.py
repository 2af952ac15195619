"""A robot's body in the simulated world: true pose, outline, odometer errors."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum, auto
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from maps.pose import Pose
from tools.simulation.convex import Corner, convex_overlap, grown, outward_normals
from tools.simulation.silhouette import Silhouette, silhouette_of
from tools.simulation.truth.robot_truth import TapeTruth

_BUMPER_ARC = math.radians(135.0)  # rad covered by a ring, centred on front or rear


@dataclass(frozen=True, slots=True)
class Outline:
    """What of a body can touch, m, base_link; by default the Pioneer 2-DX of ARIA's p2dx.p.

    corners: of a convex polygon, counter-clockwise, that the rectangle encloses; empty for the
    rectangle itself.
    """

    front: float = 0.210
    rear: float = 0.301
    half_width: float = 0.2125
    track: float = 0.3571  # between the wheels
    corners: tuple[Corner, ...] = ()

    @property
    def half_length(self) -> float:
        """Half the length, m."""
        return (self.front + self.rear) / 2

    @property
    def middle(self) -> float:
        """Where the centre lies ahead of base_link, m; negative for a Pioneer."""
        return (self.front - self.rear) / 2

    @property
    def reach(self) -> float:
        """Distance of the farthest corner from base_link, m."""
        return math.hypot(max(self.front, self.rear), self.half_width)

    @property
    def polygon(self) -> tuple[Corner, ...]:
        """The corners, of the rectangle if there are no others, counter-clockwise."""
        front, rear, half = self.front, self.rear, self.half_width
        return self.corners or ((front, -half), (front, half), (-rear, half), (-rear, -half))

    def grown(self, margin: float) -> Outline:
        """Return the outline with every side a margin, m, farther out."""
        return _grown(self, margin)

    def silhouette(self) -> Silhouette:
        """Return the outline as rays meet it."""
        return _silhouette(self)

    def perimeter(self, step: float) -> NDArray[np.float64]:
        """Return points (n, 2) in base_link along the outline, at most ``step`` m apart."""
        return _perimeter(self, step)


@lru_cache(maxsize=64)
def _silhouette(outline: Outline) -> Silhouette:
    return silhouette_of(outline.polygon)


@lru_cache(maxsize=64)
def _grown(outline: Outline, margin: float) -> Outline:
    return Outline(
        outline.front + margin,
        outline.rear + margin,
        outline.half_width + margin,
        outline.track,
        grown(outline.corners, margin) if outline.corners else (),
    )


@lru_cache(maxsize=64)
def _perimeter(outline: Outline, step: float) -> NDArray[np.float64]:
    if outline.corners:
        return _along(outline.corners, step)
    lengthwise = np.linspace(
        -outline.rear, outline.front, math.ceil(2 * outline.half_length / step) + 1
    )
    crosswise = np.linspace(
        -outline.half_width, outline.half_width, math.ceil(2 * outline.half_width / step) + 1
    )
    sides = [
        np.column_stack((lengthwise, np.full_like(lengthwise, y)))
        for y in (-outline.half_width, outline.half_width)
    ]
    ends = [
        np.column_stack((np.full_like(crosswise, x), crosswise))
        for x in (-outline.rear, outline.front)
    ]
    points = np.concatenate(sides + ends)
    points.setflags(write=False)
    return points


def _along(corners: tuple[Corner, ...], step: float) -> NDArray[np.float64]:
    """Return points (n, 2) along the sides of a polygon, at most ``step`` m apart."""
    sides = []
    for start, end in zip(corners, corners[1:] + corners[:1], strict=True):
        parts = math.ceil(math.dist(start, end) / step) + 1
        sides.append(np.linspace(start, end, parts)[:-1])
    points = np.concatenate(sides)
    points.setflags(write=False)
    return points


class BodyKind(Enum):
    """Kind of body in the world: a robot of the team, or a kind of stranger."""

    ROBOT = auto()
    PERSON = auto()
    BOX = auto()


@dataclass(slots=True, eq=False)
class RobotBody:
    """One robot or stranger. pose: true map_from_base. wheel_scales: odometer's error (left, right
    wheel)."""

    index: int
    pose: Pose
    outline: Outline = field(default_factory=Outline)
    wheel_scales: tuple[float, float] = (1.0, 1.0)
    kind: BodyKind = BodyKind.ROBOT
    silhouettes: tuple[Silhouette, ...] | None = None
    """What lasers see of it; by default its outline, which is what sonars hear."""
    tape: TapeTruth | None = None
    """Reflecting tape round it at the height of lasers."""
    turn_scale: float = 1.0
    """Turn of the body for a turn of 1 by its wheels."""
    bumper_segments: tuple[int, int] = (5, 5)
    """Of the front and the rear ring."""
    floor_patch: int = 0
    """Number of the patch of floor it stands on."""
    reach: float = field(init=False)
    """Distance of the outline's farthest corner from base_link, m."""

    def __post_init__(self) -> None:
        self.reach = self.outline.reach

    def corners_at(self, pose: Pose, margin: float = 0.0) -> NDArray[np.float64]:
        """Return the outline's corners (n, 2), map frame, grown by a margin, m."""
        outline = self.outline.grown(margin) if margin else self.outline
        c, s = math.cos(pose.theta), math.sin(pose.theta)
        return np.asarray(np.array(outline.polygon) @ np.array(((c, s), (-s, c))) + pose[:2])

    def rectangle(self, pose: Pose | None = None, margin: float = 0.0) -> tuple[float, ...]:
        """Return (centre x, centre y, theta, half length, half width), map frame, m and rad.

        pose: instead of the present one. margin: m added on every side.
        """
        pose = self.pose if pose is None else pose
        centre = pose.compose(Pose(self.outline.middle, 0.0, 0.0))
        half_length, half_width = self.outline.half_length, self.outline.half_width
        return centre.x, centre.y, pose.theta, half_length + margin, half_width + margin


def bumper_masks(
    points: NDArray[np.float64], outline: Outline, segments: tuple[int, int]
) -> tuple[int, int]:
    """Return (front, rear) bit masks of the bumper segments pressed at points (n, 2), base_link.

    The segments of a ring, e.g. five, share 135 degrees about its middle (ARIA, ArBumpers): bit 0
    is the left-most in front, the right-most behind. Between the rings, at the wheels, there is no
    bumper.
    """
    masks = [0, 0]
    bearings = np.arctan2(points[:, 1], points[:, 0] - outline.middle)
    for bearing in bearings.tolist():
        ring = 0 if abs(bearing) <= math.pi / 2 else 1
        offset = bearing if ring == 0 else math.remainder(bearing - math.pi, math.tau)
        segment = math.floor((_BUMPER_ARC / 2 - offset) / _BUMPER_ARC * segments[ring])
        if 0 <= segment < segments[ring]:
            masks[ring] |= 1 << segment
    return masks[0], masks[1]


def overlap(a: tuple[float, ...], b: tuple[float, ...]) -> bool:
    """Return whether two oriented rectangles overlap (separating axes)."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    c, s = abs(math.cos(b[2] - a[2])), abs(math.sin(b[2] - a[2]))
    for theta, (length, width), (other_length, other_width) in (
        (a[2], a[3:], b[3:]),
        (b[2], b[3:], a[3:]),
    ):
        along = dx * math.cos(theta) + dy * math.sin(theta)
        across = dy * math.cos(theta) - dx * math.sin(theta)
        if abs(along) >= length + c * other_length + s * other_width:
            return False
        if abs(across) >= width + s * other_length + c * other_width:
            return False
    return True


def bodies_overlap(body: RobotBody, pose: Pose, other: RobotBody, margin: float = 0.0) -> bool:
    """Return whether a body at a pose overlaps another one, grown by a margin, m."""
    if not overlap(body.rectangle(pose), other.rectangle(margin=margin)):
        return False
    if not body.outline.corners and not other.outline.corners:
        return True
    return convex_overlap(body.corners_at(pose), other.corners_at(other.pose, margin))


def meeting_points(body: RobotBody, other: RobotBody, margin: float) -> NDArray[np.float64]:
    """Return the points (n, 2) of a body's outline, base_link, within a margin, m, of another."""
    points = body.outline.perimeter(margin / 2)
    c, s = math.cos(body.pose.theta), math.sin(body.pose.theta)
    in_map = points @ np.array(((c, s), (-s, c))) + body.pose[:2]
    corners = other.corners_at(other.pose, margin)
    normals = outward_normals(corners)
    beyond = in_map @ normals.T - (corners * normals).sum(axis=1)
    return np.asarray(points[(beyond <= 1e-9).all(axis=1)])
