"""Tracking of teammates in a simulated room: detection, classification, memory."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from maps.pose import Pose
from robot_agent.perception.identity import Kind
from robot_agent.perception.pose_sigma import PoseSigma
from robot_agent.perception.settings import PerceptionSettings
from robot_agent.perception.track import Track
from robot_agent.perception.tracker import TeammateTracker
from tests.robot_agent.perception.simulated_room import SILHOUETTES, Box, Room, shaken

SETTINGS = PerceptionSettings()
PERIOD = 0.1  # s between scans

Path = Callable[[float], Pose]
Boxes = Callable[[float], list[Box]]


def new_tracker(room: Room) -> TeammateTracker:
    return TeammateTracker(SETTINGS, room.map, SILHOUETTES)


def run(
    tracker: TeammateTracker,
    room: Room,
    path: Path,
    boxes: Boxes,
    *,
    start: float = 0.0,
    duration: float,
    rng: np.random.Generator,
    after_each: Callable[[float, Pose], None] = lambda t, told: None,
) -> None:
    """Feed scans taken on a path, with the pose errors of a localizer."""
    for step in range(round(duration / PERIOD)):
        t = start + step * PERIOD
        told = shaken(path(t), rng)
        tracker.update(t, told, room.scan(path(t), boxes(t), rng))
        after_each(t, told)


def standing(t: float) -> Pose:
    return Pose(3.0, 4.0, 0.0)


def round_the_middle(t: float) -> Pose:
    """Drive at 0.35 m/s on a circle of 1.3 m, looking towards its inside."""
    angle = t * 0.35 / 1.3
    return Pose(6.0 + 1.3 * math.cos(angle), 4.0 + 1.3 * math.sin(angle), angle + math.pi / 2 + 0.6)


@pytest.mark.parametrize("seed", range(4))
def test_approaching_robot_is_tracked_throughout_the_visibility_range(
    room: Room, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    tracker = new_tracker(room)
    seen, errors = [], []
    offset = rng.uniform(-0.5, 0.5)

    def robot(t: float) -> Box:
        return Box(9.5 - 0.35 * t, 4.0 + offset, math.pi)

    def own(t: float) -> Pose:
        return Pose(2.0 + 0.35 * t, 4.0, 0.0)

    def check(t: float, told: Pose) -> None:
        distance = math.hypot(robot(t).x - own(t).x, offset)
        if distance < 2.4:
            closest = tracker.closest(t, told)
            seen.append(closest is not None)
            if closest is not None:
                errors.append(math.hypot(closest.x - robot(t).x, closest.y - robot(t).y))

    run(tracker, room, own, lambda t: [robot(t)], duration=9.0, rng=rng, after_each=check)
    assert len(seen) > 15
    assert np.mean(seen) > 0.97
    assert np.median(errors) < 0.1
    assert len(tracker.tracks) == 1
    assert tracker.tracks[0].vx == pytest.approx(-0.35, abs=0.12)


def test_walls_never_become_tracks(room: Room) -> None:
    rng = np.random.default_rng(10)
    tracker = new_tracker(room)
    tracks = []

    def path(t: float) -> Pose:
        return Pose(6.0 + 4.5 * math.cos(0.1 * t), 4.0 + 3.0 * math.sin(0.1 * t), 0.3 * t)

    run(
        tracker, room, path, lambda t: [], duration=150.0, rng=rng,
        after_each=lambda t, told: tracks.extend(tracker.tracks),
    )  # fmt: skip
    assert tracks == []


@pytest.mark.parametrize("error", [(0.1, 0.0, 0.0), (0.0, -0.1, 0.0), (0.0, 0.0, 2.0)])
def test_a_pose_a_decimetre_or_two_degrees_off_makes_no_tracks_of_walls(
    room: Room, error: tuple[float, float, float]
) -> None:
    rng = np.random.default_rng(20)
    tracker = new_tracker(room)
    for step in range(80):
        angle = 0.1 * step
        truth = Pose(6.0 + 4.5 * math.cos(angle), 4.0 + 2.8 * math.sin(angle), angle + math.pi / 2)
        told = truth.compose(Pose(error[0], error[1], math.radians(error[2])))
        tracker.update(step * PERIOD, told, room.scan(truth, [], rng))
        assert tracker.tracks == []


def test_larger_pose_sigma_explains_more_points(room: Room) -> None:
    rng = np.random.default_rng(21)
    pose, box = Pose(3.0, 4.0, 0.0), Box(5.0, 7.5, 0.0)
    sure, unsure = new_tracker(room), new_tracker(room)
    for step in range(10):
        points = room.scan(pose, [box], rng)
        sure.update(step * PERIOD, pose, points, sigma=PoseSigma(0.02, 0.005))
        unsure.update(step * PERIOD, pose, points, sigma=PoseSigma(0.3, 0.1))
    assert len(sure.tracks) == 1, "a robot near a wall"
    assert unsure.tracks == [], "which may be the wall itself"


@pytest.mark.parametrize("size", [(0.511, 0.425), (0.4, 0.4), (0.65, 0.3)])
def test_a_standing_box_is_a_track_but_no_teammate(room: Room, size: tuple[float, float]) -> None:
    rng = np.random.default_rng(11)
    tracker = new_tracker(room)
    known, teammates = [], []

    def check(t: float, told: Pose) -> None:
        known.append(len(tracker.tracks))
        teammates.extend(track for track in tracker.tracks if track.teammate)

    box = Box(6.0, 4.0, 0.5, *size)
    run(tracker, room, round_the_middle, lambda t: [box], duration=50.0, rng=rng, after_each=check)
    assert np.mean(known) > 0.9
    assert teammates == []


def test_a_walking_person_is_followed_and_never_a_teammate(room: Room) -> None:
    rng = np.random.default_rng(12)
    tracker = new_tracker(room)
    kinds, known = set(), []

    def legs(t: float) -> list[Box]:
        stride = 0.25 * math.sin(4.0 * t)
        x = 4.6 + 0.3 * math.sin(0.3 * t)
        y = 2.8 + 0.4 * t
        return [
            Box(x - 0.13, y + stride, 0.0, 0.13, 0.13),
            Box(x + 0.13, y - stride, 0.0, 0.13, 0.13),
        ]

    def check(t: float, told: Pose) -> None:
        known.append(len(tracker.tracks))
        kinds.update(track.kind for track in tracker.tracks)

    run(tracker, room, standing, legs, duration=6.0, rng=rng, after_each=check)
    assert np.mean(known) > 0.8
    assert np.mean(known) < 2.0  # legs far apart are two
    assert kinds == {Kind.UNKNOWN, Kind.STRANGER}


def test_teammate_that_stops_remains_a_teammate(room: Room) -> None:
    rng = np.random.default_rng(13)
    tracker = new_tracker(room)

    def robot(t: float) -> list[Box]:
        return [Box(5.0, 2.8 + 0.3 * min(t, 4.0), math.pi / 2)]

    run(tracker, room, standing, robot, duration=14.0, rng=rng)
    [track] = tracker.tracks
    assert track.teammate
    assert math.hypot(track.vx, track.vy) < 0.15
    assert math.hypot(track.x - 5.0, track.y - 4.0) < 0.1


@pytest.mark.parametrize(("speed", "least", "most"), [(0.35, 0.045, 0.06), (0.0, -0.02, 0.02)])
def test_a_housing_that_moves_is_placed_at_the_middle_of_its_robot(
    room: Room, speed: float, least: float, most: float
) -> None:
    """The heading is the velocity's; of a robot that stands it is unknown, which sigma tells."""

    def tracks(housing_ahead: float) -> list[Track]:
        tracker, found = new_tracker(room), []
        tracker.housing_ahead = housing_ahead
        run(
            tracker,
            room,
            standing,
            lambda t: [Box(4.5, 3.2 + speed * t, math.pi / 2, 0.156, 0.155)],
            duration=4.0,
            rng=np.random.default_rng(19),
            after_each=lambda t, told: found.extend(each for each in tracker.tracks if each.small),
        )
        return found

    pairs = list(zip(tracks(0.0), tracks(0.06), strict=True))
    assert len(pairs) > 20
    assert least < np.mean([housing.y - body.y for housing, body in pairs]) < most
    more = np.mean([np.trace(body.covariance - housing.covariance) for housing, body in pairs])
    assert 0.0 < more < 0.06**2
    assert (more > 0.04**2) == (speed == 0.0)


def crossing(t: float) -> list[Box]:
    return [Box(4.5, 3.0 + 0.35 * t, math.pi / 2)]


def test_unseen_teammate_is_kept_for_3_s_with_decaying_velocity(
    room: Room,
) -> None:
    rng = np.random.default_rng(14)
    tracker = new_tracker(room)
    run(tracker, room, standing, crossing, duration=3.0, rng=rng)
    [before] = tracker.tracks
    assert before.teammate
    last_seen = before.last_seen

    remembered = []

    def note(t: float, told: Pose) -> None:
        closest = tracker.closest(t, standing(t))
        if closest is not None:
            assert closest.last_seen == last_seen
            assert math.hypot(closest.x - before.x, closest.y - before.y) < 0.5
            remembered.append(t - last_seen)

    run(tracker, room, standing, lambda t: [], start=3.0, duration=5.0, rng=rng, after_each=note)
    assert 2.85 <= max(remembered) <= 3.0 + 1e-9
    assert len(remembered) >= 29
    assert tracker.tracks == []


def test_track_memory_ends_without_scans(room: Room) -> None:
    rng = np.random.default_rng(15)
    tracker = new_tracker(room)
    run(tracker, room, standing, crossing, duration=3.0, rng=rng)
    last_seen = tracker.tracks[0].last_seen
    assert tracker.closest(last_seen + 2.9, standing(0.0)) is not None
    assert tracker.closest(last_seen + 3.1, standing(0.0)) is None


def test_visibility_ends_at_its_range_with_a_margin_for_those_in_view(room: Room) -> None:
    rng = np.random.default_rng(16)
    tracker = new_tracker(room)
    run(tracker, room, standing, crossing, duration=3.0, rng=rng)
    t = tracker.tracks[0].last_seen
    [track] = tracker.tracks

    def at_distance(distance: float) -> Pose:
        return Pose(track.x - distance, track.y, 0.0)

    assert tracker.closest(t, at_distance(2.55)) is None
    assert tracker.closest(t, at_distance(2.45)) is not None
    assert tracker.closest(t, at_distance(2.55)) is not None
    assert tracker.closest(t, at_distance(2.65)) is None
    assert tracker.closest(t, at_distance(2.55)) is None


def test_two_robots_are_two_tracks_and_the_nearer_is_the_closest(room: Room) -> None:
    rng = np.random.default_rng(17)
    tracker = new_tracker(room)
    ids: set[tuple[int, ...]] = set()
    nearest_errors = []

    def robots(t: float) -> list[Box]:
        # They drive towards each other and pass 0.8 m apart.
        return [Box(4.6, 2.6 + 0.3 * t, math.pi / 2), Box(5.4, 5.4 - 0.3 * t, -math.pi / 2)]

    def check(t: float, told: Pose) -> None:
        if t > 3.0:
            mates = [track for track in tracker.tracks if track.teammate]
            ids.add(tuple(track.id for track in mates))
            for track, box in zip(mates, robots(t), strict=True):
                assert math.hypot(track.x - box.x, track.y - box.y) < 0.45
            closest = tracker.closest(t, told)
            assert closest is not None
            near = min(robots(t), key=lambda box: math.hypot(box.x - 3.0, box.y - 4.0))
            nearest_errors.append(math.hypot(closest.x - near.x, closest.y - near.y))

    run(tracker, room, standing, robots, duration=9.0, rng=rng, after_each=check)
    assert len(ids) == 1
    assert len(ids.pop()) == 2
    assert np.median(nearest_errors) < 0.1


def test_equal_inputs_give_equal_tracks(room: Room) -> None:
    def outcome() -> list[tuple[float, ...]]:
        tracker = new_tracker(room)
        run(tracker, room, standing, crossing, duration=4.0, rng=np.random.default_rng(18))
        return [
            (track.id, track.x, track.y, track.vx, track.vy, *track.covariance.ravel())
            for track in tracker.tracks
        ]

    first = outcome()
    assert first
    assert first == outcome()


def test_scan_without_returns_is_accepted(room: Room) -> None:
    tracker = new_tracker(room)
    tracker.update(0.0, Pose(3.0, 4.0, 0.0), np.empty((0, 2)))
    assert tracker.tracks == []
    assert tracker.closest(0.0, Pose(3.0, 4.0, 0.0)) is None


def test_track_that_starts_abruptly_keeps_its_id(room: Room) -> None:
    """A person who stood walks off at 1.2 m/s between two scans."""
    rng = np.random.default_rng(21)
    tracker = TeammateTracker(PerceptionSettings(), room.map, SILHOUETTES)
    here, period, numbers = Pose(4.0, 4.0, 0.0), 0.2, set()
    for step in range(30):
        t = step * period
        walked = max(t - 3.0, 0.0) * 1.2
        person = Box(5.5, 3.2 + walked, math.pi / 2, 0.28, 0.44)
        tracker.update(t, here, room.scan(here, [person], rng))
        numbers |= {track.id for track in tracker.tracks}
    assert len(numbers) == 1
    [track] = tracker.tracks
    assert math.hypot(track.x - person.x, track.y - person.y) < 0.2
    assert math.hypot(track.vx, track.vy) == pytest.approx(1.2, abs=0.3)


def test_two_tracks_of_one_object_merge_under_the_older_id(room: Room) -> None:
    """Detected again slightly aside, outside the gate, but nearer than two objects can be."""
    rng = np.random.default_rng(22)
    tracker = TeammateTracker(SETTINGS, room.map, SILHOUETTES, gate_distance=0.2)
    here = Pose(4.0, 4.0, 0.0)
    for step in range(10):
        tracker.update(0.2 * step, here, room.scan(here, [Box(6.0, 4.0, 0.0)], rng))
    [before] = tracker.tracks
    for step in range(10, 16):
        tracker.update(0.2 * step, here, room.scan(here, [Box(6.0, 4.3, 0.0)], rng))
    [after] = tracker.tracks
    assert after.id == before.id
    assert after.first_seen == before.first_seen
    assert math.hypot(after.x - 6.0, after.y - 4.3) < 0.1


@pytest.mark.parametrize("seed", range(3))
def test_without_camera_a_robot_turning_in_place_counts_as_closest(room: Room, seed: int) -> None:
    """It comes into view at 1.8 m round a corner and does not move: too near to wait for motion."""
    tracker, rng = new_tracker(room), np.random.default_rng(seed)

    def turning(t: float) -> list[Box]:
        return [Box(4.8, 4.1, 0.6 * t)]

    run(tracker, room, standing, turning, duration=1.0, rng=rng)
    (track,) = tracker.tracks
    assert track.kind is Kind.UNKNOWN
    assert tracker.closest(0.9, standing(0.9)) is not None
    # With pictures it does not count before they give evidence.
    tracker.on_bands(0.95, standing(0.95), [])
    assert tracker.closest(1.0, standing(1.0)) is None


def test_unknown_track_without_a_robots_outline_does_not_count(room: Room) -> None:
    tracker, rng = new_tracker(room), np.random.default_rng(1)

    def standing_bench(t: float) -> list[Box]:
        return [Box(4.8, 4.1, 0.3, 0.8, 0.3)]

    run(tracker, room, standing, standing_bench, duration=3.0, rng=rng)
    assert len(tracker.tracks) == 1
    assert tracker.closest(2.9, standing(2.9)) is None
