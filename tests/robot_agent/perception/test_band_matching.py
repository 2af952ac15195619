"""Bands in pictures go to the tracks they are on; tracks without the band they should show."""

from __future__ import annotations

import math

import numpy as np

from drivers.camera_source import CameraSettings
from maps.pose import Pose
from robot_agent.perception.band_matching import BandMatcher
from robot_agent.perception.blob import Blob
from robot_agent.perception.color_settings import ColorSettings
from robot_agent.perception.identity import Kind, Probabilities
from robot_agent.perception.track import Track

CAMERA = CameraSettings()
HERE = Pose(4.0, 3.0, 0.7)
LENS = HERE.compose(Pose(*CAMERA.mount))
MATCHER = BandMatcher(CAMERA, ColorSettings())


def track(distance: float, bearing: float) -> Track:
    place = LENS.compose(Pose(distance * math.cos(bearing), distance * math.sin(bearing), 0.0))
    return Track(
        id=1, x=place.x, y=place.y, vx=0.0, vy=0.0, covariance=0.05**2 * np.eye(2),
        first_seen=0.0, last_seen=0.0, kind=Kind.UNKNOWN,
        probabilities=Probabilities(0.0, 0.0, 1.0), robot_sized=True, moving=False, by_color=False,
    )  # fmt: skip


def band(distance: float, bearing: float) -> Blob:
    return Blob(bearing, 0.0, 0.2, 0.05, distance - 0.2, 0.15, 0.8)


def test_each_band_goes_to_its_track_whatever_the_order() -> None:
    tracks = [track(1.5, 0.3), track(2.2, -0.2)]
    found = MATCHER.match(HERE, tracks, [band(2.2, -0.2), band(1.5, 0.3)])
    assert found.banded == {0: 0.8, 1: 0.8}
    assert found.bare == []


def test_a_band_in_the_same_direction_but_far_behind_is_another_ones() -> None:
    found = MATCHER.match(HERE, [track(1.2, 0.1)], [band(2.6, 0.1)])
    assert found.banded == {}
    assert found.bare == [0]


def test_whoever_is_not_whole_in_the_picture_is_not_judged() -> None:
    outside = [track(1.5, 1.2), track(0.4, 0.0), track(3.9, 0.0), track(1.5, 0.6)]
    assert MATCHER.match(HERE, outside, []).bare == []


def test_whoever_is_hidden_is_not_judged() -> None:
    found = MATCHER.match(HERE, [track(1.0, 0.0), track(2.5, 0.05)], [])
    assert found.bare == [0]


def test_one_band_makes_one_of_two_neighbours_a_teammate() -> None:
    tracks = [track(2.0, 0.25), track(2.0, -0.1)]
    found = MATCHER.match(HERE, tracks, [band(2.0, 0.23)])
    assert list(found.banded) == [0]
    assert found.bare == [1]
