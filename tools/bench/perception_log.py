"""Figures of the robots' perception: their tracks against the true positions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from maps.border import Border
from maps.pose import Pose
from robot_agent.agent import Agent
from robot_agent.perception.intruders import Intruder
from robot_agent.perception.track import Track
from tools.simulation.robot_body import BodyKind, RobotBody
from tools.simulation.world import World

VISIBILITY = 2.5  # m
SETTLED_S = 0.5  # in view before a detection is due
CLASSED_S = 1.0  # in view before its classification is due
SAME_M = 0.5  # a track this near to a robot belongs to it
FRESH_S = 0.25  # only tracks seen within this time are compared
HALF_CAMERA = math.radians(
    30.0
)  # off the axis, to each side: a robot within is wholly in the picture


@dataclass(slots=True)
class _Visit:
    """A stranger's stay near the border in view of one robot."""

    since: float
    until: float
    events: set[int] = field(default_factory=set)
    """Numbers of the intruders that the robot reported for it."""


class PerceptionLog:
    """Counts the bodies in view of each robot and their detections and classifications."""

    def __init__(
        self, world: World, border: Border | None = None, field_of_view_deg: float = 180.0
    ) -> None:
        """Compare with the bodies of ``world``; strangers near the border must be reported.

        field_of_view_deg: of the robots' lasers, centred ahead.
        """
        self._half_view = math.radians(field_of_view_deg / 2)
        self._world = world
        self._border = border
        self._in_view_since: dict[tuple[int, int], float] = {}
        self._due = self._seen = 0
        self._classed = self._class_right = 0
        self._classed_ahead = self._right_ahead = 0
        self._teammates = self._false_teammates = 0
        self._stranger_tracks = self._misclassified = 0
        self._errors: list[float] = []
        self._visits: dict[tuple[int, int], list[_Visit]] = {}
        self._reports: dict[tuple[int, int], bool] = {}
        """By (robot index, intruder number): whether a stranger was there."""

    def sample(self, t: float, body: RobotBody, agent: Agent) -> None:
        """Compare one robot's tracks at t with the true positions."""
        tracks = agent.perception.tracker.tracks_at(t)  # as passed to the patrol
        others = [other for other in self._world.bodies if other is not body]
        team = [other for other in others if other.kind is BodyKind.ROBOT]
        strangers = [other for other in others if other.kind is not BodyKind.ROBOT]
        for other in team:
            self._sample_pair(t, body, other, tracks)
        for track in tracks:
            if t - track.last_seen >= FRESH_S:
                continue
            if track.teammate:
                self._teammates += 1
                nearest = min((_distance(track, other) for other in team), default=math.inf)
                self._false_teammates += nearest > SAME_M
            if any(_distance(track, other) < SAME_M for other in strangers) and not any(
                _distance(track, other) < SAME_M for other in team
            ):
                self._stranger_tracks += 1
                self._misclassified += track.teammate
        known = agent.perception.intruders.known if agent.perception.intruders else []
        self._sample_reports(t, body, strangers, known)
        for stranger in strangers:
            self._sample_visit(t, body, stranger, known)

    def _sample_pair(
        self, t: float, body: RobotBody, other: RobotBody, tracks: Sequence[Track]
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
        if not near:
            return
        track = min(near, key=lambda each: _distance(each, other))
        self._seen += 1
        self._errors.append(_distance(track, other))
        if t - since < CLASSED_S:
            return
        self._classed += 1
        self._class_right += track.teammate
        seen = body.pose.between(_middle(other))
        if abs(math.atan2(seen.y, seen.x)) < HALF_CAMERA:
            self._classed_ahead += 1
            self._right_ahead += track.teammate

    def _sample_reports(
        self, t: float, body: RobotBody, strangers: Sequence[RobotBody], known: Sequence[Intruder]
    ) -> None:
        """Store for each newly reported intruder whether any stranger is there."""
        for intruder in known:
            key = (body.index, intruder.number)
            if key not in self._reports and t - intruder.last_seen < 1.0:
                places = [(other.pose.x, other.pose.y) for other in strangers]
                self._reports[key] = any(
                    math.dist((intruder.x, intruder.y), place) < 2.0 * SAME_M for place in places
                )

    def _sample_visit(
        self, t: float, body: RobotBody, stranger: RobotBody, known: Sequence[Intruder]
    ) -> None:
        """Update the stays of a stranger near the border in view of a robot."""
        assert self._border is not None
        visits = self._visits.setdefault((body.index, stranger.index), [])
        foot = self._border.project(stranger.pose.x, stranger.pose.y)
        if foot.distance < ZONE and self._in_view(body, stranger):
            if not visits or t - visits[-1].until > GAP_S:
                visits.append(_Visit(t, t))
            visits[-1].until = t
        if visits and t - visits[-1].until < LATE_S:
            visits[-1].events |= {
                each.number
                for each in known
                if t - each.last_seen < 1.0 and self._is_at(each, stranger)
            }

    def _is_at(self, intruder: Intruder, stranger: RobotBody) -> bool:
        """Whether an intruder is at a stranger's position, nearer than to any other stranger."""
        place = (intruder.x, intruder.y)
        others = [body for body in self._world.bodies if body.kind is not BodyKind.ROBOT]
        nearest = min(others, key=lambda other: math.dist(place, other.pose[:2]))
        return nearest is stranger and math.dist(place, stranger.pose[:2]) < SAME_M

    def _in_view(self, body: RobotBody, other: RobotBody) -> bool:
        """Whether the centre of a body is in the laser's view: near, not aside, not occluded."""
        seen = body.pose.between(_middle(other))
        distance = math.hypot(seen.x, seen.y)
        if distance > VISIBILITY or abs(math.atan2(seen.y, seen.x)) >= self._half_view:
            return False
        bearing = math.atan2(seen.y, seen.x) + body.pose.theta
        if self._world.free_way(body.pose.x, body.pose.y, bearing) <= distance:
            return False
        return not any(
            _is_occluded(body, other, third)
            for third in self._world.bodies
            if third is not body and third is not other
        )

    def figures(self) -> dict[str, Any]:
        """Return the figures of ``bench --json``; None where nothing was in view."""
        stays = [
            visit
            for visits in self._visits.values()
            for visit in visits
            if visit.until - visit.since >= STAY_S
        ]
        return {
            "recall": _share(self._seen, self._due),
            "class_right": _share(self._class_right, self._classed),
            "class_right_in_picture": _share(self._right_ahead, self._classed_ahead),
            "false_teammate": _share(self._false_teammates, self._teammates),
            "position_error_m": {
                "p95": float(np.percentile(self._errors, 95)) if self._errors else None
            },
            "scans_in_view": self._due,
            "strangers": {
                "tracked": self._stranger_tracks,
                "taken_for_teammate": _share(self._misclassified, self._stranger_tracks),
                "stays": len(stays),
                "stays_reported_once": sum(len(visit.events) == 1 for visit in stays),
                "stays_unreported": sum(not visit.events for visit in stays),
                "reports": len(self._reports),
                "reports_of_nobody": sum(not there for there in self._reports.values()),
            },
        }


ZONE = 2.0  # m from the border
STAY_S = 3.0  # in view near the border for at least this: a report is due
GAP_S = 3.0  # out of view for longer ends a stay
LATE_S = 1.0  # a report this long after a stay's end still counts


def _share(part: int, whole: int) -> float | None:
    return part / whole if whole else None


def _is_occluded(body: RobotBody, other: RobotBody, third: RobotBody) -> bool:
    """Whether a third body occludes the centre of another from the first's laser."""
    target, between = body.pose.between(_middle(other)), body.pose.between(_middle(third))
    distance = math.hypot(target.x, target.y)
    along = (between.x * target.x + between.y * target.y) / distance
    aside = abs(between.x * target.y - between.y * target.x) / distance
    return 0.0 < along < distance and aside < third.reach + 0.15


def _middle(body: RobotBody) -> Pose:
    """Return the centre of a body's outline, which the tracker estimates."""
    return body.pose.compose(Pose(body.outline.middle, 0.0, 0.0))


def _distance(track: Track, body: RobotBody) -> float:
    middle = _middle(body)
    return math.hypot(track.x - middle.x, track.y - middle.y)
