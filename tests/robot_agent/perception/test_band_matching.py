"""Association of bands with tracks, and tracks whose band is missing."""

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


def test_each_band_is_assigned_to_its_track_in_any_order() -> None:
    tracks = [track(1.5, 0.3), track(2.2, -0.2)]
    found = MATCHER.match(HERE, tracks, [band(2.2, -0.2), band(1.5, 0.3)], NOTHING)
    assert found.banded == {0: 0.8, 1: 0.8}
    assert found.bare == []


def test_band_far_behind_a_track_is_not_assigned_to_it() -> None:
    found = MATCHER.match(HERE, [track(1.2, 0.1)], [band(2.6, 0.1)], NOTHING)
    assert found.banded == {}
    assert found.bare == [0]


def test_track_at_the_picture_edge_or_out_of_range_is_not_bare() -> None:
    outside = [track(1.5, 1.2), track(0.35, 0.0), track(3.9, 0.0), track(1.5, 0.64)]
    assert MATCHER.match(HERE, outside, [], NOTHING).bare == []


def test_band_cut_by_the_picture_edge_is_matched_by_its_visible_part() -> None:
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
def test_occluded_track_is_not_bare(distance: float, bearing: float) -> None:
    between = LENS.compose(Pose(distance * math.cos(bearing), distance * math.sin(bearing), 0.0))
    seen = np.array([between[:2], (20.0, 20.0)])
    assert MATCHER.match(HERE, [track(2.5, 0.05)], [], seen).bare == []


def test_points_of_its_surface_beside_or_behind_do_not_occlude() -> None:
    places = [(2.1, 0.05), (1.0, 0.6), (1.0, -0.5), (3.5, 0.05)]
    seen = np.array(
        [LENS.compose(Pose(d * math.cos(b), d * math.sin(b), 0.0))[:2] for d, b in places]
    )
    assert MATCHER.match(HERE, [track(2.5, 0.05)], [], seen).bare == [0]


def test_one_band_makes_only_one_of_two_tracks_a_teammate() -> None:
    tracks = [track(2.0, 0.25), track(2.0, -0.1)]
    found = MATCHER.match(HERE, tracks, [band(2.0, 0.23)], NOTHING)
    assert list(found.banded) == [0]
    assert found.bare == [1]
