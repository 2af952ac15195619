"""Bands in pictures go to the tracks they are on; tracks without the band they should show."""

from __future__ import annotations

import math

import numpy as np
import pytest

from drivers.camera_source import CameraSettings
from maps.pose import Pose
from robot_agent.messages.blob import Blob
from robot_agent.perception.band_matching import BandMatcher
from robot_agent.perception.identity import Kind, Probabilities
from robot_agent.perception.track import Track

CAMERA = CameraSettings()
HERE = Pose(4.0, 3.0, 0.7)
LENS = HERE.compose(Pose(*CAMERA.mount))
MATCHER = BandMatcher(CAMERA)
NOTHING = np.empty((0, 2))


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
    found = MATCHER.match(HERE, tracks, [band(2.2, -0.2), band(1.5, 0.3)], NOTHING)
    assert found.banded == {0: 0.8, 1: 0.8}
    assert found.bare == []


def test_a_band_in_the_same_direction_but_far_behind_is_another_ones() -> None:
    found = MATCHER.match(HERE, [track(1.2, 0.1)], [band(2.6, 0.1)], NOTHING)
    assert found.banded == {}
    assert found.bare == [0]


def test_whoever_is_hardly_in_the_picture_too_near_or_far_is_not_judged() -> None:
    outside = [track(1.5, 1.2), track(0.35, 0.0), track(3.9, 0.0), track(1.5, 0.64)]
    assert MATCHER.match(HERE, outside, [], NOTHING).bare == []


def test_of_whoever_is_cut_by_the_edge_of_the_picture_the_rest_tells() -> None:
    edge = math.atan(0.5 * CAMERA.width / CAMERA.focal_length)
    distance, bearing = 0.7, 0.5
    half = math.asin(0.25 / distance)
    assert bearing + half > edge + 0.1, "cut"
    shown = math.atan(0.5 * (math.tan(bearing - half) + math.tan(edge)))
    assert shown < bearing - 0.06, "the middle of what is shown is another one"
    for side in (1.0, -1.0):
        cut = [track(distance, side * bearing)]
        assert MATCHER.match(HERE, cut, [band(distance, side * shown)], NOTHING).banded == {0: 0.8}
        assert MATCHER.match(HERE, cut, [], NOTHING).bare == [0]
        assert (
            MATCHER.match(HERE, cut, [band(distance, side * (shown - 0.4))], NOTHING).banded == {}
        )


@pytest.mark.parametrize(("distance", "bearing"), [(1.0, 0.0), (1.0, -0.1), (1.9, 0.14)])
def test_whoever_is_hidden_or_may_be_in_part_is_not_judged(distance: float, bearing: float) -> None:
    between = LENS.compose(Pose(distance * math.cos(bearing), distance * math.sin(bearing), 0.0))
    seen = np.array([between[:2], (20.0, 20.0)])
    assert MATCHER.match(HERE, [track(2.5, 0.05)], [], seen).bare == []


def test_own_surface_and_what_is_beside_or_behind_hide_nobody() -> None:
    places = [(2.1, 0.05), (1.0, 0.6), (1.0, -0.5), (3.5, 0.05)]
    seen = np.array(
        [LENS.compose(Pose(d * math.cos(b), d * math.sin(b), 0.0))[:2] for d, b in places]
    )
    assert MATCHER.match(HERE, [track(2.5, 0.05)], [], seen).bare == [0]


def test_one_band_makes_one_of_two_neighbours_a_teammate() -> None:
    tracks = [track(2.0, 0.25), track(2.0, -0.1)]
    found = MATCHER.match(HERE, tracks, [band(2.0, 0.23)], NOTHING)
    assert list(found.banded) == [0]
    assert found.bare == [1]
