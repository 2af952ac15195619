"""Which band in a picture belongs to which track, and which tracks lack one they should show."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from drivers.camera_source import CameraSettings
from maps.pose import Pose
from robot_agent.perception.blob import Blob
from robot_agent.perception.color_settings import ColorSettings
from robot_agent.perception.track import Track

_GATE = 9.2  # squared Mahalanobis distance: 99 % of two dimensions
_BEARING_SIGMA = 0.04  # rad; a band's middle is not the outline's, and the robot turns meanwhile
_SURFACE = 0.2  # m from a robot's middle to its sides, where the band is
_SURFACE_SIGMA = 0.1  # m
_HALF_WIDTH = 0.25  # m of a robot, that must be in the picture
_NEAREST = 0.55  # m from the lens to the middle; nearer ones do not fit into the picture
_FAR = 1e6


@dataclass(frozen=True, slots=True)
class _Sighted:
    """A track as the lens sees it: bearing rad, distance m, their sigmas."""

    index: int
    bearing: float
    distance: float
    bearing_sigma: float
    distance_sigma: float


@dataclass(frozen=True, slots=True)
class Matches:
    """banded: confidence of the band of each track that has one, by its index. bare: tracks whose
    band would be in the picture and is not."""

    banded: dict[int, float]
    bare: list[int]


class BandMatcher:
    """Compares pictures with tracks."""

    def __init__(self, camera: CameraSettings, color: ColorSettings) -> None:
        self._mount = Pose(*camera.mount)
        self._half_view = math.atan(0.5 * camera.width / camera.focal_length)
        self._range = color.range

    def match(self, pose: Pose, tracks: Sequence[Track], blobs: Sequence[Blob]) -> Matches:
        """Match a picture's blobs with the tracks at that time; pose: map_from_base then."""
        lens = pose.compose(self._mount)
        sighted = [self._sight(lens, index, track) for index, track in enumerate(tracks)]
        banded = _assign(sighted, blobs)
        bare = [
            each.index
            for each in sighted
            if each.index not in banded and self._in_view(each) and not _hidden(each, sighted)
        ]
        return Matches(banded, bare)

    def _sight(self, lens: Pose, index: int, track: Track) -> _Sighted:
        dx, dy = track.x - lens.x, track.y - lens.y
        distance = max(math.hypot(dx, dy), 0.05)
        ux, uy = dx / distance, dy / distance
        P = track.covariance
        along = P[0, 0] * ux * ux + 2.0 * P[0, 1] * ux * uy + P[1, 1] * uy * uy
        across = P[0, 0] * uy * uy - 2.0 * P[0, 1] * ux * uy + P[1, 1] * ux * ux
        return _Sighted(
            index,
            math.remainder(math.atan2(dy, dx) - lens.theta, math.tau),
            distance,
            math.hypot(_BEARING_SIGMA, math.sqrt(float(across)) / distance),
            math.hypot(_SURFACE_SIGMA, math.sqrt(float(along))),
        )

    def _in_view(self, each: _Sighted) -> bool:
        margin = math.asin(min(_HALF_WIDTH / each.distance, 1.0)) + 2.0 * each.bearing_sigma
        near_enough = _NEAREST <= each.distance <= self._range - 0.8
        return near_enough and abs(each.bearing) + margin < self._half_view


def _hidden(each: _Sighted, others: Sequence[_Sighted]) -> bool:
    """Tell whether something nearer may stand before it."""
    return any(
        other.distance < each.distance - 0.2
        and abs(other.bearing - each.bearing)
        < math.asin(min(_HALF_WIDTH / other.distance, 1.0)) + _HALF_WIDTH / each.distance
        for other in others
        if other is not each
    )


def _assign(sighted: Sequence[_Sighted], blobs: Sequence[Blob]) -> dict[int, float]:
    """Return the confidence of the best band within the gate of each track that has one."""
    if not sighted or not blobs:
        return {}
    cost = np.array([[_distance(each, blob) for blob in blobs] for each in sighted])
    cost[cost > _GATE] = _FAR
    rows, columns = linear_sum_assignment(cost)
    return {
        sighted[row].index: blobs[column].confidence
        for row, column in zip(rows.tolist(), columns.tolist(), strict=True)
        if cost[row, column] < _FAR
    }


def _distance(each: _Sighted, blob: Blob) -> float:
    """Return the squared Mahalanobis distance of a band from where a track's would be."""
    bearing = (blob.bearing - each.bearing) / each.bearing_sigma
    off = blob.range + _SURFACE - each.distance
    return bearing**2 + off**2 / (each.distance_sigma**2 + blob.range_sigma**2)
