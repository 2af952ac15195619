"""The teammate tracker: scans and poses in, the closest teammate out."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from maps.occupancy_map import OccupancyMap
from maps.pose import Pose
from robot_agent.perception.segments import Segment, find_segments
from robot_agent.perception.settings import PerceptionSettings
from robot_agent.perception.track import Track
from robot_agent.perception.track_filter import Detection, TrackFilter
from robot_agent.perception.unexplained import UnexplainedPoints

_TENTATIVE_MISSES = 2  # scans in a row that end an unconfirmed track


class TeammateTracker:
    """Follows robot-sized things that are not in the map and knows which of them are teammates.

    A track is confirmed after a few detections, a teammate once it has been seen moving (and from
    then on), and remembered for a while unseen: a robot that turned away does not forget.
    """

    def __init__(self, settings: PerceptionSettings, occupancy: OccupancyMap) -> None:
        self._settings = settings
        self._unexplained = UnexplainedPoints(settings, occupancy)
        self._filters: list[TrackFilter] = []
        self._next_id = 1
        self._t = 0.0
        self._visible: set[int] = set()

    @property
    def tracks(self) -> list[Track]:
        """The confirmed tracks, oldest first, as of the latest scan."""
        return [each.track_at(self._t) for each in self._filters if each.confirmed]

    def update(self, t: float, pose: Pose, points: NDArray[np.float64]) -> None:
        """Take in a scan measured at t, s.

        pose: map_from_base at t. points: (n, 2) m, base_link, ordered by bearing, beams without
        a return left out.
        """
        self._t = t
        detections = self._detect(pose, points)
        for each in self._filters:
            each.predict(t)
        unmatched = self._associate(t, detections)
        self._filters = [each for each in self._filters if self._alive(each, t)]
        for detection in unmatched:
            if not detection.whole:
                continue
            self._filters.append(TrackFilter(self._settings, self._next_id, t, detection))
            self._next_id += 1

    def covered(
        self, t: float, pose: Pose, points: NDArray[np.float64]
    ) -> NDArray[np.bool_] | None:
        """Return (n,) which points (n, 2), base_link, lie on tracks just seen; None: too many.

        pose: map_from_base at t, s. Most of a scan on tracks would mean that the tracks are walls
        seen from a wrong pose.
        """
        covered = np.zeros(len(points), dtype=np.bool_)
        c, s = math.cos(pose.theta), math.sin(pose.theta)
        for each in self._filters:
            if not each.confirmed or t - each.last_seen > self._settings.cover_memory:
                continue
            track = each.track_at(t)
            dx, dy = track.x - pose.x, track.y - pose.y
            away = np.hypot(points[:, 0] - (c * dx + s * dy), points[:, 1] - (c * dy - s * dx))
            covered |= away < self._settings.cover
        if np.count_nonzero(covered) > self._settings.most_covered * len(points):
            return None
        return covered

    def closest(self, t: float, pose: Pose) -> Track | None:
        """Return the nearest teammate in the visibility range, predicted to t, or None.

        pose: map_from_base at t. A teammate unseen counts for as long as it is remembered; one
        that was in range is kept to a slightly larger distance, so that it does not flicker.
        """
        nearest, nearest_distance = None, math.inf
        visible = set()
        for each in self._filters:
            if not each.teammate or t - each.last_seen > self._settings.memory:
                continue
            track = each.track_at(t)
            distance = math.hypot(track.x - pose.x, track.y - pose.y)
            margin = self._settings.visibility_margin if each.id in self._visible else 0.0
            if distance > self._settings.visibility + margin:
                continue
            visible.add(each.id)
            if distance < nearest_distance:
                nearest, nearest_distance = track, distance
        self._visible = visible
        return nearest

    def _detect(self, pose: Pose, points: NDArray[np.float64]) -> list[Detection]:
        """Return the robot-sized segments of a scan in the map frame."""
        ranges = np.hypot(points[:, 0], points[:, 1])
        unexplained = self._unexplained.mask(pose, points, ranges)
        segments = find_segments(points, ranges, unexplained, self._settings)
        return [self._in_map(pose, segment) for segment in segments]

    def _in_map(self, pose: Pose, segment: Segment) -> Detection:
        """Carry a segment's centre into the map, adding what the pose's error does to it."""
        settings = self._settings
        distance = math.hypot(segment.x, segment.y)
        direction = pose.theta + math.atan2(segment.y, segment.x)
        c, s = math.cos(direction), math.sin(direction)
        along = segment.sigma_along**2 + settings.pose_sigma_xy**2
        across = (
            segment.sigma_across**2
            + settings.pose_sigma_xy**2
            + (distance * settings.pose_sigma_theta) ** 2
        )
        return Detection(
            x=pose.x + distance * c,
            y=pose.y + distance * s,
            var_x=c * c * along + s * s * across,
            var_y=s * s * along + c * c * across,
            cov_xy=c * s * (along - across),
            whole=segment.whole,
        )

    def _associate(self, t: float, detections: list[Detection]) -> list[Detection]:
        """Give each track its detection, nearest pairs first; return those that fit no track."""
        pairs = sorted(
            (distance, i, j)
            for i, each in enumerate(self._filters)
            for j, detection in enumerate(detections)
            if (distance := each.gate_distance(detection)) < math.inf
        )
        matched: set[int] = set()
        taken: set[int] = set()
        for _, i, j in pairs:
            if i not in matched and j not in taken:
                matched.add(i)
                taken.add(j)
                self._filters[i].hit(t, detections[j])
        for i, each in enumerate(self._filters):
            if i not in matched:
                each.miss()
        return [detection for j, detection in enumerate(detections) if j not in taken]

    def _alive(self, each: TrackFilter, t: float) -> bool:
        if not each.confirmed:
            return each.misses < _TENTATIVE_MISSES
        return t - each.last_seen <= self._settings.memory
