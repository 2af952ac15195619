"""Data association of bands in a picture with tracks, and detection of missing bands."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivers.camera_source import CameraSettings
from maps.pose import Pose
from robot_agent.messages.blob import Blob
from robot_agent.perception.assignment import cheapest_pairs
from robot_agent.perception.band_detector import BAND_RANGE
from robot_agent.perception.track import Track

_GATE = 9.2  # squared Mahalanobis distance: 99 % of two dimensions
_BEARING_SIGMA = 0.04  # rad; offset of band and outline centres, and the robot's turn meanwhile
_SURFACE = 0.2  # m from a robot's middle to its sides, where the band is
_SURFACE_SIGMA = 0.1  # m
_HALF_WIDTH = 0.25  # m of a robot
_MIN_SHARE = 0.4  # of its width that must be in the picture for a band to be found
_NEAREST = 0.4  # m from the lens to the middle; nearer robots fill the picture
_BODY = 0.5  # m; laser points nearer to the lens than a body's middle by more may occlude it


@dataclass(frozen=True, slots=True)
class _Sighted:
    """A track in the lens frame: bearing, rad, distance, m, and their sigmas.

    index: of the track. band_bearing: rad, of the middle of the part of its width in the picture.
    """

    index: int
    bearing: float
    band_bearing: float
    distance: float
    bearing_sigma: float
    distance_sigma: float


@dataclass(frozen=True, slots=True)
class Matches:
    """Result of the association.

    banded: confidence of the band by index of the track that has it. bare: indices of the tracks
    whose band should be in the picture and is missing.
    """

    banded: dict[int, float]
    bare: list[int]


class BandMatcher:
    """Associates the bands of pictures with tracks."""

    def __init__(self, camera: CameraSettings) -> None:
        self._mount = Pose(*camera.mount)
        self._half_view = math.atan(0.5 * camera.width / camera.focal_length)

    def match(
        self,
        pose: Pose,
        tracks: Sequence[Track],
        blobs: Sequence[Blob],
        seen: NDArray[np.float64],
    ) -> Matches:
        """Match a picture's blobs with the tracks at that time; pose: map_from_base then.

        tracks: predicted to that time. seen: the laser's points of about then, (n, 2), m, map
        frame, for occlusion.
        """
        lens = pose.compose(self._mount)
        sighted = [self._sight(lens, index, track) for index, track in enumerate(tracks)]
        banded = _assign(sighted, blobs)
        bare = [
            each.index
            for each in sighted
            if each.index not in banded and self._in_view(each) and not _hidden(each, lens, seen)
        ]
        return Matches(banded, bare)

    def _sight(self, lens: Pose, index: int, track: Track) -> _Sighted:
        dx, dy = track.x - lens.x, track.y - lens.y
        distance = max(math.hypot(dx, dy), 0.05)
        bearing = math.remainder(math.atan2(dy, dx) - lens.theta, math.tau)
        ux, uy = dx / distance, dy / distance
        P = track.covariance
        along = P[0, 0] * ux * ux + 2.0 * P[0, 1] * ux * uy + P[1, 1] * uy * uy
        across = P[0, 0] * uy * uy - 2.0 * P[0, 1] * ux * uy + P[1, 1] * ux * ux
        return _Sighted(
            index,
            bearing,
            self._middle_in_picture(bearing, distance),
            distance,
            math.hypot(_BEARING_SIGMA, math.sqrt(float(across)) / distance),
            math.hypot(_SURFACE_SIGMA, math.sqrt(float(along))),
        )

    def _middle_in_picture(self, bearing: float, distance: float) -> float:
        """Return the bearing, rad, of the middle of the part of a body's width in the picture."""
        half = _half_angle(distance)
        right = max(bearing - half, -self._half_view)
        left = min(bearing + half, self._half_view)
        if right >= left:
            return bearing  # beside the picture
        return math.atan(0.5 * (math.tan(right) + math.tan(left)))

    def _in_view(self, each: _Sighted) -> bool:
        """Return whether enough of a track's width is in the picture, within two sigma."""
        outer = abs(each.bearing) + 2.0 * each.bearing_sigma
        farthest = self._half_view + (1.0 - 2.0 * _MIN_SHARE) * _half_angle(each.distance)
        return _NEAREST <= each.distance <= BAND_RANGE - 0.8 and outer < farthest


def _hidden(each: _Sighted, lens: Pose, seen: NDArray[np.float64]) -> bool:
    """Return whether nearer points seen (n, 2), m, map frame, may occlude any part of a track."""
    dx, dy = seen[:, 0] - lens.x, seen[:, 1] - lens.y
    off = np.arctan2(dy, dx) - (lens.theta + each.bearing)
    off -= math.tau * np.round(off / math.tau)
    width = _half_angle(each.distance) + 2.0 * each.bearing_sigma
    before = (np.abs(off) < width) & (np.hypot(dx, dy) < each.distance - _BODY)
    return bool(before.any())


def _half_angle(distance: float) -> float:
    """Return the angle, rad, of half a robot's width at a distance, m."""
    return math.asin(min(_HALF_WIDTH / distance, 1.0))


def _assign(sighted: Sequence[_Sighted], blobs: Sequence[Blob]) -> dict[int, float]:
    """Return the confidence of the band assigned to each track that has one, by track index."""
    if not sighted or not blobs:
        return {}
    cost = [[_gate_distance(each, blob) for blob in blobs] for each in sighted]
    return {sighted[row].index: blobs[column].confidence for row, column in cheapest_pairs(cost)}


def _gate_distance(each: _Sighted, blob: Blob) -> float:
    """Return the squared Mahalanobis distance of a band from a track's expected one.

    Infinite beyond the gate.
    """
    bearing = (blob.bearing - each.band_bearing) / each.bearing_sigma
    off = blob.range + _SURFACE - each.distance
    squared = bearing**2 + off**2 / (each.distance_sigma**2 + blob.range_sigma**2)
    return squared if squared <= _GATE else math.inf
