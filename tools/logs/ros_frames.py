"""Frames of a ROS recording (tf): where a sensor is on its robot, and the robot in the map."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from maps.pose import Pose

_UPSIDE_DOWN = -0.5
"""Of the z axis' upward part, below which a sensor is upside down; between, it is upright."""


@dataclass(frozen=True, slots=True, eq=False)
class Transform:
    """``parent_from_child``: rotation (3, 3) and translation (3,), m."""

    rotation: NDArray[np.float64]
    translation: NDArray[np.float64]

    def compose(self, other: Transform) -> Transform:
        """Return ``a_from_c`` of ``a_from_b`` and ``b_from_c``."""
        return Transform(
            self.rotation @ other.rotation, self.rotation @ other.translation + self.translation
        )

    def inverse(self) -> Transform:
        """Return ``child_from_parent``."""
        return Transform(self.rotation.T, -self.rotation.T @ self.translation)

    @property
    def upside_down(self) -> bool:
        """Whether the child's z axis points down."""
        return bool(self.rotation[2, 2] < _UPSIDE_DOWN)

    @property
    def planar(self) -> Pose:
        """The pose seen from above: x, y and the heading of the child's x axis."""
        x, y = self.translation[:2].tolist()
        return Pose(x, y, math.atan2(self.rotation[1, 0], self.rotation[0, 0]))


_IDENTITY = Transform(np.eye(3), np.zeros(3))


def transform_of(message: Any) -> Transform:
    """Return the transform of a ``geometry_msgs`` Transform or Pose."""
    place = message.translation if hasattr(message, "translation") else message.position
    turn = message.rotation if hasattr(message, "rotation") else message.orientation
    x, y, z, w = (float(value) for value in (turn.x, turn.y, turn.z, turn.w))
    length = math.sqrt(x * x + y * y + z * z + w * w) or 1.0
    x, y, z, w = x / length, y / length, z / length, w / length
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    return Transform(rotation, np.array([place.x, place.y, place.z], dtype=np.float64))


@dataclass(slots=True, eq=False)
class FrameTree:
    """The frames of a recording, as its tf messages give them."""

    parents: dict[str, str] = field(default_factory=dict)
    history: defaultdict[str, list[tuple[float, Transform]]] = field(
        default_factory=lambda: defaultdict(list)
    )
    """By child, its transforms with their times, s, as they came."""

    def add(self, t: float, parent: str, child: str, transform: Transform) -> None:
        """Store a transform at t; leading slashes of old ROS 1 names are dropped."""
        self.parents[child.lstrip("/")] = parent.lstrip("/")
        self.history[child.lstrip("/")].append((t, transform))

    def fixed(self, frame: str, child: str) -> Transform | None:
        """Return ``frame_from_child`` of two frames of one rigid body; None if tf joins them not.

        Of a joint that moves, the first transform counts.
        """
        up = {frame: _IDENTITY, **self._above(frame)}
        down = {child: _IDENTITY, **self._above(child)}
        for common, common_from_child in down.items():
            if common in up:
                return up[common].inverse().compose(common_from_child)
        return None

    def planar_at(self, child: str, times: Sequence[float]) -> list[Pose] | None:
        """Return the pose of a child in its parent at times, the latest at or before each.

        None without any.
        """
        known = sorted(self.history.get(child, ()), key=lambda each: each[0])
        if not known:
            return None
        stamps = [t for t, _ in known]
        return [known[max(bisect_right(stamps, t) - 1, 0)][1].planar for t in times]

    def _above(self, frame: str) -> dict[str, Transform]:
        """Return ``ancestor_from_frame`` of each ancestor, nearest first."""
        found: dict[str, Transform] = {}
        transform = _IDENTITY
        while frame in self.parents and self.parents[frame] not in found:
            transform = self.history[frame][0][1].compose(transform)
            frame = self.parents[frame]
            found[frame] = transform
        return found
