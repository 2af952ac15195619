"""How well the robots see each other: their tracks against the true positions."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from maps.pose import Pose
from robot_agent.perception.track import Track
from tools.bench.robot_body import RobotBody
from tools.bench.world import World

VISIBILITY = 2.5  # m
SETTLED_S = 0.5  # in view before a robot must have been detected
SAME_M = 0.5  # a track this near a robot is of that robot
FRESH_S = 0.25  # a track seen within this time is compared with what is there now


class PerceptionLog:
    """Counts, robot by robot, what was in view and what the tracker made of it."""

    def __init__(self, world: World) -> None:
        """Compare with this world's bodies."""
        self._world = world
        self._in_view_since: dict[tuple[int, int], float] = {}
        self._due = 0
        self._seen = 0
        self._class_right = 0
        self._teammates = 0
        self._false_teammates = 0
        self._errors: list[float] = []

    def sample(self, t: float, body: RobotBody, tracks: list[Track]) -> None:
        """Compare one robot's tracks at t with the robots that are truly there."""
        others = [other for other in self._world.bodies if other is not body]
        for other in others:
            self._sample_pair(t, body, other, tracks)
        for track in tracks:
            if track.teammate and t - track.last_seen < FRESH_S:
                self._teammates += 1
                nearest = min((_distance(track, other) for other in others), default=math.inf)
                self._false_teammates += nearest > SAME_M

    def _sample_pair(
        self, t: float, body: RobotBody, other: RobotBody, tracks: list[Track]
    ) -> None:
        pair = (body.index, other.index)
        if not self._in_view(body, other):
            self._in_view_since.pop(pair, None)
            return
        since = self._in_view_since.setdefault(pair, t)
        if t - since < SETTLED_S:
            return
        self._due += 1
        near = [track for track in tracks if _distance(track, other) < SAME_M]
        if near:
            track = min(near, key=lambda each: _distance(each, other))
            self._seen += 1
            self._class_right += track.teammate
            self._errors.append(_distance(track, other))

    def _in_view(self, body: RobotBody, other: RobotBody) -> bool:
        """Tell whether the laser sees the middle of another robot: near, ahead, nothing between."""
        seen = body.pose.between(_middle(other))
        distance = math.hypot(seen.x, seen.y)
        if distance > VISIBILITY or seen.x <= 0.0:
            return False
        bearing = math.atan2(seen.y, seen.x) + body.pose.theta
        return self._world.free_way(body.pose.x, body.pose.y, bearing) > distance

    def figures(self) -> dict[str, Any]:
        """Return the figures of ``bench --json``; None where nothing was in view."""
        return {
            "recall": self._seen / self._due if self._due else None,
            "class_right": self._class_right / self._seen if self._seen else None,
            "false_teammate": self._false_teammates / self._teammates if self._teammates else None,
            "position_error_m": {
                "p95": float(np.percentile(self._errors, 95)) if self._errors else None
            },
        }


def _middle(body: RobotBody) -> Pose:
    """Return the middle of a robot's outline, which is what a tracker estimates."""
    return body.pose.compose(Pose(body.outline.middle, 0.0, 0.0))


def _distance(track: Track, body: RobotBody) -> float:
    middle = _middle(body)
    return math.hypot(track.x - middle.x, track.y - middle.y)
