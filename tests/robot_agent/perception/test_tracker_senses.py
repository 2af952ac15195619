"""Evidence of pictures, sonars and reflectors for the laser's tracks."""

from __future__ import annotations

import math

import numpy as np
import pytest

from drivers.camera_source import CameraSettings
from maps.pose import Pose
from robot_agent.messages.blob import Blob
from robot_agent.perception.identity import Kind
from robot_agent.perception.segments import MEAN_HALF_WIDTH
from robot_agent.perception.settings import PerceptionSettings
from robot_agent.perception.tracker import TeammateTracker
from tests.robot_agent.perception.simulated_room import SILHOUETTES, Box, Room

PERIOD = 0.1
HERE = Pose(3.0, 4.0, 0.0)
CAMERA = CameraSettings()


def band_on(box: Box) -> Blob:
    lens = HERE.compose(Pose(*CAMERA.mount))
    dx, dy = box.x - lens.x, box.y - lens.y
    return Blob(math.atan2(dy, dx), 0.0, 0.2, 0.05, math.hypot(dx, dy) - 0.2, 0.15, 0.9)


def watched(room: Room, seconds: float, *, worn: tuple[bool, ...]) -> TeammateTracker:
    """Return a tracker that saw standing robots for a while, with pictures of their bands."""
    rng = np.random.default_rng(1)
    tracker = TeammateTracker(PerceptionSettings(), room.map, SILHOUETTES, CAMERA)
    boxes = [Box(5.0, 4.5, 0.4), Box(5.0, 3.2, 1.9)][: len(worn)]
    for step in range(round(seconds / PERIOD)):
        t = step * PERIOD
        tracker.update(t, HERE, room.scan(HERE, boxes, rng))
        if step % 2:
            bands = [band_on(box) for box, wears in zip(boxes, worn, strict=True) if wears]
            tracker.on_bands(t, HERE, bands)
    return tracker


def test_a_standing_robot_with_a_band_is_a_teammate_and_one_without_a_stranger(room: Room) -> None:
    tracks = watched(room, 1.5, worn=(True, False)).tracks
    kinds = {round(track.y, 0): track.kind for track in tracks}
    assert len(tracks) == 2
    assert sorted(kinds.values()) == [Kind.STRANGER, Kind.TEAMMATE]
    mate = next(track for track in tracks if track.teammate)
    assert mate.y > 4.0


def test_a_stranger_as_large_as_a_robot_is_never_the_closest_teammate(room: Room) -> None:
    tracker = watched(room, 2.0, worn=(False,))
    assert tracker.closest(1.9, HERE) is None


@pytest.mark.parametrize("pictures", [True, False])
@pytest.mark.parametrize(
    ("length", "width", "speed", "kind"),
    [
        (0.511, 0.425, 0.3, Kind.TEAMMATE),
        (0.511, 0.425, 0.0, Kind.UNKNOWN),  # standing, it may be a box of a robot's size
        (0.7, 0.6, 0.3, Kind.STRANGER),  # a cart
        (0.511, 0.425, 0.9, Kind.STRANGER),  # faster than any robot
    ],
)
def test_outside_the_picture_outline_and_motion_classify(
    room: Room, length: float, width: float, speed: float, kind: Kind, *, pictures: bool
) -> None:
    rng = np.random.default_rng(2)
    tracker = TeammateTracker(PerceptionSettings(), room.map, SILHOUETTES, CAMERA)
    for step in range(21):
        t = step * PERIOD
        body = Box(4.2, 5.6 - speed * t, -math.pi / 2, length, width)
        tracker.update(t, HERE, room.scan(HERE, [body], rng))
        if pictures:
            tracker.on_bands(t, HERE, [])
    assert [track.kind for track in tracker.tracks] == [kind]


def test_sonar_echoes_extend_a_teammates_track_for_a_while(room: Room) -> None:
    tracker = watched(room, 2.0, worn=(True,))
    [mate] = tracker.tracks
    turned = Pose(HERE.x, HERE.y, math.pi)
    echo = turned.between(Pose(mate.x - 0.2, mate.y, 0.0))
    last, remembered = mate.last_seen, 0.0
    for step in range(120):
        t = last + PERIOD * (step + 1)
        tracker.update(t, turned, room.scan(turned, [], np.random.default_rng(step)))
        if tracker.needs_echoes(t):
            tracker.on_echoes(t, turned, np.array([[echo.x, echo.y]]))
        if tracker.closest(t, turned) is not None:
            remembered = t - last
    assert 6.0 < remembered <= 9.1, "as long as a sonar counts, then the usual memory"


def test_sonar_echo_does_not_bring_a_teammate_nearer(room: Room) -> None:
    tracker = watched(room, 2.0, worn=(True,))
    [mate] = tracker.tracks
    turned = Pose(HERE.x, HERE.y, math.pi)
    seen = turned.between(Pose(mate.x, mate.y, 0.0))
    distance = math.hypot(seen.x, seen.y)
    near_side = np.array([[seen.x, seen.y]]) * (1.0 - MEAN_HALF_WIDTH / distance)
    for step in range(30):
        t = mate.last_seen + PERIOD * (step + 1)
        tracker.update(t, turned, room.scan(turned, [], np.random.default_rng(step)))
        tracker.on_echoes(t, turned, near_side)
    heard = tracker.closest(t, turned)
    assert heard is not None
    assert math.dist((heard.x, heard.y), HERE[:2]) == pytest.approx(distance, abs=0.05)


def test_echo_of_a_wall_extends_no_track(room: Room) -> None:
    tracker = watched(room, 2.0, worn=(True,))
    last = tracker.tracks[0].last_seen
    turned = Pose(HERE.x, HERE.y, math.pi)
    wall = turned.between(Pose(HERE.x, 7.95, 0.0))
    for step in range(50):
        t = last + PERIOD * (step + 1)
        tracker.update(t, turned, room.scan(turned, [], np.random.default_rng(step)))
        tracker.on_echoes(t, turned, np.array([[wall.x, wall.y]]))
    assert tracker.tracks == []


def test_reflector_makes_a_teammate_without_a_camera(room: Room) -> None:
    rng = np.random.default_rng(4)
    for reflecting, kind in ((True, Kind.TEAMMATE), (False, Kind.UNKNOWN)):
        settings = PerceptionSettings(reflecting_bands=reflecting)
        tracker = TeammateTracker(settings, room.map, SILHOUETTES, CAMERA)
        for step in range(15):
            points = room.scan(HERE, [Box(3.3, 5.6, 0.3)], rng)
            near = np.hypot(points[:, 0] - 0.3, points[:, 1] - 1.6) < 0.4
            tracker.update(step * PERIOD, HERE, points, near)
        assert [track.kind for track in tracker.tracks] == [kind]
