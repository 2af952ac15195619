"""The tracker: classified tracks from scans, pictures, sonar echoes and poses."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drivers.camera_source import CameraSettings
from maps.border import Border
from maps.occupancy_map import OccupancyMap
from maps.pose import Pose
from robot_agent.messages.blob import Blob
from robot_agent.perception.assignment import cheapest_pairs
from robot_agent.perception.band_matching import BandMatcher
from robot_agent.perception.pose_sigma import USUAL_POSE_SIGMA, PoseSigma
from robot_agent.perception.scan_points import move_points
from robot_agent.perception.segments import MEAN_HALF_WIDTH, Segment, find_segments
from robot_agent.perception.settings import PerceptionSettings
from robot_agent.perception.silhouette import Silhouettes
from robot_agent.perception.track import TRACK_MEMORY, Track
from robot_agent.perception.track_filter import GATE_DISTANCE, Detection, TrackFilter
from robot_agent.perception.unexplained import UnexplainedPoints
from robot_agent.perception.visibility import VISIBILITY, VISIBILITY_MARGIN

_COVER_MARGIN = 0.12  # m round a track just seen: beams that end there are not of walls
COVER_MEMORY = 0.5  # s that a track counts as just seen
MAX_COVERED = 0.5  # share of a scan's beams
SONAR_GATE = 0.5  # m from a track out of the laser's view to a sonar echo of it
SONAR_SIGMA = 0.2  # m
SONAR_MEMORY = 6.0  # s since the laser's last detection
_IN_THE_WAY = 0.6  # m from the border to the middle of a robot that lets none pass there
_TENTATIVE_MISSES = 2  # scans in a row that end an unconfirmed track
_SEEN_LATELY = 0.35  # s before a picture within which a track's position holds for the picture
_PICTURES_PAUSE = 1.0  # s without a clear picture, after which the laser alone classifies
_ONE_BODY = 0.35  # m; two objects' centres are never nearer to each other


class TeammateTracker:
    """Tracks objects that are not in the map and classifies them: teammate, stranger or unknown.

    A track is confirmed after a few detections. The team's band in a picture makes it a teammate;
    outside the camera's view, so does a teammate's silhouette at a robot's speed. A track is kept
    for ``TRACK_MEMORY`` without a detection.
    """

    def __init__(
        self,
        settings: PerceptionSettings,
        occupancy: OccupancyMap,
        silhouettes: Silhouettes,
        camera: CameraSettings | None = None,
        border: Border | None = None,
        *,
        gate_distance: float = GATE_DISTANCE,
        max_covered: float = MAX_COVERED,
    ) -> None:
        """Start without tracks.

        gate_distance: m; no association of a detection farther from a track. max_covered: share of
        a scan's points above which ``covered`` returns None.
        """
        self.silhouettes = silhouettes
        """What teammates may look like."""
        self.housing_ahead = 0.0
        """m from the middle of a teammate's body to that of its scanner's housing."""
        self._border = border
        self._reflecting_bands = settings.reflecting_bands
        self._gate_distance, self._max_covered = gate_distance, max_covered
        self.unexplained = UnexplainedPoints(occupancy, settings.detection_range)
        """Classifier of a scan's points that the map does not explain."""
        self._matcher = BandMatcher(camera or CameraSettings())
        self._filters: list[TrackFilter] = []
        self._next_id = 1
        self._t = 0.0
        self._pictured_at = -math.inf
        self._visible: set[int] = set()
        self._pose, self._points = Pose(0.0, 0.0, 0.0), np.empty((0, 2))  # of the latest scan

    @property
    def tracks(self) -> list[Track]:
        """The confirmed tracks, oldest first, as of the latest scan."""
        return self.tracks_at(self._t)

    def tracks_at(self, t: float) -> list[Track]:
        """Return the confirmed tracks, oldest first, predicted to t."""
        return [each.track_at(t) for each in self._filters if each.confirmed]

    def update(
        self,
        t: float,
        pose: Pose,
        points: NDArray[np.float64],
        reflectors: NDArray[np.bool_] | None = None,
        sigma: PoseSigma | None = None,
    ) -> None:
        """Update all tracks by a scan measured at t.

        pose: map_from_base at t; sigma: of the pose, None for the usual one. points: (n, 2), m,
        base_link, ordered by bearing, beams without a return left out. reflectors: (n,) which
        points are of a reflector; None if the laser does not report them.
        """
        self._t, self._pose, self._points = t, pose, points
        detections = self._detect(pose, points, reflectors, sigma)
        for each in self._filters:
            each.predict(t)
        unmatched = self._associate(t, detections)
        for each in self._filters:
            each.watch_approach(t, pose)
        self._filters = [each for each in self._filters if self._alive(each, t)]
        self._merge_duplicates()
        for detection in unmatched:
            if not detection.whole:
                continue
            self._filters.append(
                TrackFilter(
                    self._next_id,
                    t,
                    detection,
                    reflecting_bands=self._reflecting_bands,
                    housing_ahead=self.housing_ahead,
                )
            )
            self._next_id += 1

    def on_bands(self, t: float, pose: Pose, blobs: Sequence[Blob]) -> None:
        """Update tracks by the bands of a clear picture taken at t; pose: map_from_base at t."""
        self._pictured_at = t
        seen = [
            each for each in self._filters if each.confirmed and t - each.last_seen < _SEEN_LATELY
        ]
        if not seen:
            return
        tracks = [each.track_at(t) for each in seen]
        matches = self._matcher.match(pose, tracks, blobs, move_points(self._points, self._pose))
        for index, confidence in matches.banded.items():
            seen[index].identity.on_band(confidence)
        for index in matches.bare:
            seen[index].identity.on_missing_band()

    def needs_echoes(self, t: float) -> bool:
        """Return whether there is a teammate's track at t to update by sonar, unseen by laser."""
        return bool(self._unseen(t))

    def _unseen(self, t: float) -> list[TrackFilter]:
        return [
            each
            for each in self._filters
            if each.teammate and each.misses and t - each.last_seen <= SONAR_MEMORY
        ]

    def on_echoes(self, t: float, pose: Pose, echoes: NDArray[np.float64]) -> None:
        """Update tracks by sonar echoes (n, 2), m, base_link at t; pose: map_from_base at t.

        For ``SONAR_MEMORY`` echoes update a teammate's track that the laser does not see; they
        never start one, as they cannot be told from echoes of walls. An echo is taken as of the
        near side of a robot.
        """
        unseen = self._unseen(t)
        if not unseen or not len(echoes):
            return
        ranges = np.hypot(echoes[:, 0], echoes[:, 1])
        free = self.unexplained.mask(pose, echoes, ranges) & (ranges > 0.0)
        to_middle = 1.0 + MEAN_HALF_WIDTH / ranges[free]
        middles = echoes[free] * to_middle[:, None]
        in_map = move_points(middles, pose)
        for each in unseen:
            track = each.track_at(t)
            away = np.hypot(in_map[:, 0] - track.x, in_map[:, 1] - track.y)
            if away.size and float(away.min()) < SONAR_GATE:
                x, y = in_map[int(away.argmin())].tolist()
                each.predict(t)
                each.update_by_echo(t, x, y, SONAR_SIGMA)

    def covered(
        self, t: float, pose: Pose, points: NDArray[np.float64]
    ) -> NDArray[np.bool_] | None:
        """Return (n,) which points (n, 2), m, base_link, are of tracks just seen.

        pose: map_from_base at t. None if more than ``max_covered`` of the points are: then the
        tracks are probably walls seen from a wrong pose.
        """
        covered = np.zeros(len(points), dtype=np.bool_)
        c, s = math.cos(pose.theta), math.sin(pose.theta)
        for each in self._filters:
            if not each.confirmed or t - each.last_seen > COVER_MEMORY:
                continue
            track = each.track_at(t)
            dx, dy = track.x - pose.x, track.y - pose.y
            away = np.hypot(points[:, 0] - (c * dx + s * dy), points[:, 1] - (c * dy - s * dx))
            covered |= away < self.silhouettes.reach + _COVER_MARGIN
        if np.count_nonzero(covered) > self._max_covered * len(points):
            return None
        return covered

    def closest(self, t: float, pose: Pose) -> Track | None:
        """Return the nearest teammate in the visibility range, predicted to t, or None.

        pose: map_from_base at t. A teammate without detections counts for ``TRACK_MEMORY``; the
        range has a hysteresis of ``VISIBILITY_MARGIN``. Whatever is like a robot and comes nearer
        counts as one, unless pictures show no band: two robots that do not recognize each other
        would stop nose to nose. Without pictures, a track with a robot's outline on the border
        counts before it has moved: a robot that turns in place behind a corner would be recognized
        too late, and anything else there blocks the way.
        """
        blind = t - self._pictured_at > _PICTURES_PAUSE
        nearest, nearest_distance = None, math.inf
        visible = set()
        for each in self._filters:
            counts = (
                each.teammate
                or (each.confirmed and each.approached_lately(t))
                or (blind and each.confirmed and each.may_be_teammate and self._blocks(each))
            )
            if not counts or t - each.supported > TRACK_MEMORY:
                continue
            track = each.track_at(t)
            distance = math.hypot(track.x - pose.x, track.y - pose.y)
            margin = VISIBILITY_MARGIN if each.id in self._visible else 0.0
            if distance > VISIBILITY + margin:
                continue
            visible.add(each.id)
            if distance < nearest_distance:
                nearest, nearest_distance = track, distance
        self._visible = visible
        return nearest

    def _blocks(self, each: TrackFilter) -> bool:
        """Return whether a track is so near the border that no robot passes; True without one."""
        return self._border is None or self._border.nearest(*each.position)[0] < _IN_THE_WAY

    def _detect(
        self,
        pose: Pose,
        points: NDArray[np.float64],
        reflectors: NDArray[np.bool_] | None,
        sigma: PoseSigma | None,
    ) -> list[Detection]:
        """Return the segments of a scan that may be a robot or a person, in the map frame."""
        ranges = np.hypot(points[:, 0], points[:, 1])
        unexplained = self.unexplained.mask(pose, points, ranges, sigma)
        segments = find_segments(self.silhouettes, points, ranges, unexplained, reflectors)
        known = USUAL_POSE_SIGMA if sigma is None else sigma
        return [_in_map(pose, segment, known) for segment in segments]

    def _associate(self, t: float, detections: list[Detection]) -> list[Detection]:
        """Assign detections to tracks by the smallest total distance; return those unassigned."""
        taken: set[int] = set()
        matched: set[int] = set()
        if self._filters and detections:
            cost = [
                [each.gate_distance(detection, self._gate_distance) for detection in detections]
                for each in self._filters
            ]
            for i, j in cheapest_pairs(cost):
                matched.add(i)
                taken.add(j)
                self._filters[i].hit(t, detections[j])
        for i, each in enumerate(self._filters):
            if i not in matched:
                each.miss()
        return [detection for j, detection in enumerate(detections) if j not in taken]

    def _merge_duplicates(self) -> None:
        """Merge two tracks nearer to each other than two objects can be.

        An object that accelerates, or shows another side, may be lost and start a new track.
        """
        for newer in reversed(self._filters):
            if not newer.confirmed or newer.misses:
                continue
            older = next(
                (
                    each
                    for each in self._filters
                    if each.id < newer.id
                    and each.confirmed
                    and each.misses
                    and each.distance_to(newer) < _ONE_BODY
                ),
                None,
            )
            if older is not None:
                older.merge(newer)
                self._filters.remove(newer)

    def _alive(self, each: TrackFilter, t: float) -> bool:
        if not each.confirmed:
            return each.misses < _TENTATIVE_MISSES
        return t - each.supported <= TRACK_MEMORY


def _in_map(pose: Pose, segment: Segment, sigma: PoseSigma) -> Detection:
    """Transform a segment to the map frame; its covariance includes that of the pose."""
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    dx, dy = c * segment.x - s * segment.y, s * segment.x + c * segment.y
    turning, place = sigma.theta**2, sigma.xy**2
    twice = 2.0 * c * s * segment.cov_xy
    return Detection(
        x=pose.x + dx,
        y=pose.y + dy,
        var_x=c * c * segment.var_x - twice + s * s * segment.var_y + place + dy * dy * turning,
        var_y=s * s * segment.var_x + twice + c * c * segment.var_y + place + dx * dx * turning,
        cov_xy=c * s * (segment.var_x - segment.var_y)
        + (c * c - s * s) * segment.cov_xy
        - dx * dy * turning,
        whole=segment.whole,
        robot_sized=segment.robot_sized,
        small=segment.small,
        misfit=segment.misfit,
        reflecting=segment.reflecting,
        legs=segment.legs,
    )
