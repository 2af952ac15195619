"""A robot's body in the simulated world: true pose, outline, odometer errors."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum, auto
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from maps.pose import Pose
from tools.simulation.silhouette import Silhouette, silhouette_of

BUMPER_SEGMENTS = 5  # per ring
_BUMPER_ARC = math.radians(135.0)  # rad covered by a ring, centred on front or rear


@dataclass(frozen=True, slots=True)
class Outline:
    """A rectangle round base_link, m; by default the Pioneer 2-DX of ARIA's p2dx.p."""

    front: float = 0.210
    rear: float = 0.301
    half_width: float = 0.2125
    track: float = 0.3571  # between the wheels

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

    def silhouette(self) -> Silhouette:
        """Return the rectangle as rays meet it."""
        return _silhouette(self)

    def perimeter(self, step: float) -> NDArray[np.float64]:
        """Return points (n, 2) in base_link along the outline, at most ``step`` m apart."""
        return _perimeter(self, step)


@lru_cache(maxsize=64)
def _silhouette(outline: Outline) -> Silhouette:
    front, rear, half = outline.front, outline.rear, outline.half_width
    return silhouette_of([(front, -half), (front, half), (-rear, half), (-rear, -half)])


@lru_cache(maxsize=64)
def _perimeter(outline: Outline, step: float) -> NDArray[np.float64]:
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
    turn_scale: float = 1.0
    """Turn of the body for a turn of 1 by its wheels."""
    floor_patch: int = 0
    """Number of the patch of floor it stands on."""
    reach: float = field(init=False)
    """Distance of the outline's farthest corner from base_link, m."""

    def __post_init__(self) -> None:
        self.reach = self.outline.reach

    def rectangle(self, pose: Pose | None = None, margin: float = 0.0) -> tuple[float, ...]:
        """Return (centre x, centre y, theta, half length, half width), map frame, m and rad.

        pose: instead of the present one. margin: m added on every side.
        """
        pose = self.pose if pose is None else pose
        centre = pose.compose(Pose(self.outline.middle, 0.0, 0.0))
        half_length, half_width = self.outline.half_length, self.outline.half_width
        return centre.x, centre.y, pose.theta, half_length + margin, half_width + margin


def bumper_masks(points: NDArray[np.float64], outline: Outline) -> tuple[int, int]:
    """Return (front, rear) bit masks of the bumper segments pressed at points (n, 2), base_link.

    Segment i of a ring covers 27 degrees about 67.5 - (i + 0.5) * 27 degrees from the ring's
    middle, counter-clockwise (ARIA, ArBumpers): bit 0 is the left-most in front, the right-most
    behind. Between the rings, at the wheels, there is no bumper.
    """
    masks = [0, 0]
    bearings = np.arctan2(points[:, 1], points[:, 0] - outline.middle)
    for bearing in bearings.tolist():
        ring = 0 if abs(bearing) <= math.pi / 2 else 1
        offset = bearing if ring == 0 else math.remainder(bearing - math.pi, math.tau)
        segment = math.floor((_BUMPER_ARC / 2 - offset) / (_BUMPER_ARC / BUMPER_SEGMENTS))
        if 0 <= segment < BUMPER_SEGMENTS:
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


def meeting_points(body: RobotBody, other: RobotBody, margin: float) -> NDArray[np.float64]:
    """Return the points (n, 2) of a body's outline, base_link, within a margin, m, of another."""
    points = body.outline.perimeter(margin / 2)
    c, s = math.cos(body.pose.theta), math.sin(body.pose.theta)
    in_map = points @ np.array(((c, s), (-s, c))) + body.pose[:2]
    x, y, theta, half_length, half_width = other.rectangle(margin=margin)
    c, s = math.cos(theta), math.sin(theta)
    along = (in_map[:, 0] - x) * c + (in_map[:, 1] - y) * s
    across = (in_map[:, 1] - y) * c - (in_map[:, 0] - x) * s
    return np.asarray(points[(np.abs(along) <= half_length) & (np.abs(across) <= half_width)])
