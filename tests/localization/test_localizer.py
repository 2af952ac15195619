"""The whole localizer in a room without symmetry, and on the first scans of a real log."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from localization.health import Health
from localization.localizer import Localizer
from localization.settings import LocalizationSettings
from maps.occupancy_map import MapError, OccupancyMap
from maps.pose import Pose, wrap_angle
from tools.localize.localize import log_steps
from tools.localize.occlusion import Occlusion
from tools.logs.carmen import read_carmen
from tools.mapping.map_build import build_map

DRIFT = 0.06  # rad per metre, as the odometry of an old robot


class WornOdometer:
    """Odometry that counts 3 % too much and turns as it goes."""

    def __init__(self) -> None:
        self.pose = Pose(100.0, -50.0, 1.0)

    def count(self, step: Pose) -> Pose:
        travel = math.hypot(step.x, step.y)
        self.pose = self.pose.compose(
            Pose(1.03 * step.x, 1.03 * step.y, step.theta + DRIFT * travel)
        )
        return self.pose


def error(estimate_pose: Pose, truth: Pose) -> tuple[float, float]:
    return (
        math.hypot(estimate_pose.x - truth.x, estimate_pose.y - truth.y),
        abs(math.degrees(wrap_angle(estimate_pose.theta - truth.theta))),
    )


def track(localizer: Localizer, room, poses: list[Pose], seed: int = 5) -> list:
    rng, odometer = np.random.default_rng(seed), WornOdometer()
    estimates = []
    for index, pose in enumerate(poses):
        step = poses[index - 1].between(pose) if index else Pose(0, 0, 0)
        odometry = odometer.count(step)
        estimates.append(localizer.update(0.1 * index, odometry, room.scan(pose, rng)))
    return estimates


def new_localizer(room, seed: int = 1, **settings) -> Localizer:
    return Localizer(LocalizationSettings(**settings), room.map, np.random.default_rng(seed))


def test_update_before_a_start_raises(room) -> None:
    localizer = new_localizer(room)
    assert localizer.estimate is None
    with pytest.raises(RuntimeError, match="start"):
        localizer.update(0.0, Pose(0, 0, 0), room.scan(Pose(3, 2, 0)))
    localizer.start_at(Pose(3, 2, 0), 0.1, 0.1)
    assert localizer.estimate is None


def test_tracks_at_patrol_speed_within_centimetres(room, circle) -> None:
    localizer = new_localizer(room)
    start = circle[0]
    localizer.start_at(Pose(start.x + 0.1, start.y - 0.1, start.theta + 0.05), 0.2, 0.1)
    estimates = track(localizer, room, circle)
    errors = np.array([error(e.pose, p) for e, p in zip(estimates, circle, strict=True)])
    assert np.percentile(errors[10:, 0], 95) < 0.03
    assert np.percentile(errors[10:, 1], 95) < 0.7
    assert all(e.health is Health.LOCALIZED for e in estimates[10:])
    assert estimates[-1].particle_count < 600
    assert localizer.weights.sum() == pytest.approx(1.0)
    assert localizer.particles.shape == (len(localizer.weights), 3)


def test_covariance_covers_the_error(room, circle) -> None:
    localizer = new_localizer(room)
    localizer.start_at(circle[0], 0.1, 0.05)
    estimates = track(localizer, room, circle)
    ratios = []
    for estimate, truth in zip(estimates, circle, strict=True):
        covariance = estimate.covariance
        assert covariance == pytest.approx(covariance.T)
        assert np.linalg.eigvalsh(covariance).min() > 0
        assert math.sqrt(covariance[0, 0] + covariance[1, 1]) < 0.3
        away = np.array([*np.subtract(estimate.pose[:2], truth[:2]), 0.0])
        away[2] = wrap_angle(estimate.pose.theta - truth.theta)
        ratios.append(away @ np.linalg.solve(covariance, away))
    assert np.percentile(ratios, 95) < 11.3  # chi-square of 3, 99 %


def test_same_seed_gives_the_same_estimates_and_another_seed_others(room, circle) -> None:
    runs = []
    for seed in (7, 7, 8):
        localizer = new_localizer(room, seed)
        localizer.start_at(circle[0], 0.1, 0.05)
        estimates = track(localizer, room, circle[:30])
        runs.append([(e.pose, e.likelihood, e.particle_count) for e in estimates])
    assert runs[0] == runs[1]
    assert runs[0] != runs[2]


def test_a_fixed_number_of_particles_is_kept(room, circle) -> None:
    localizer = new_localizer(room, particles=400)
    localizer.start_at(circle[0], 0.1, 0.05)
    assert {e.particle_count for e in track(localizer, room, circle[:40])} == {400}


def test_covariance_does_not_shrink_at_standstill(room) -> None:
    localizer = new_localizer(room)
    here = Pose(4.0, 2.0, 0.3)
    localizer.start_at(here, 0.1, 0.05)
    points = room.scan(here, np.random.default_rng(1))
    for index in range(300):
        estimate = localizer.update(0.1 * index, Pose(0, 0, 0), points)
    assert math.sqrt(estimate.covariance[0, 0]) > 0.01
    assert estimate.health is Health.LOCALIZED
    assert error(estimate.pose, here)[0] < 0.03


def test_filter_follows_a_robot_pushed_at_standing_odometry(room) -> None:
    """The robot is pushed 1 m aside and turned by hand while the odometer stands still."""
    localizer = new_localizer(room)
    rng = np.random.default_rng(1)
    localizer.start_at(Pose(3.0, 1.5, 0.5), 0.1, 0.05)
    for index in range(80):
        share = min(1.0, max(0.0, (index - 10) / 40))
        truth = Pose(3.0 + 0.3 * share, 1.5 + share, 0.5 + 1.2 * share)
        estimate = localizer.update(0.1 * index, Pose(0, 0, 0), room.scan(truth, rng))
    assert error(estimate.pose, truth)[0] < 0.05
    assert error(estimate.pose, truth)[1] < 1.0
    assert estimate.health is Health.LOCALIZED


def test_people_around_the_robot_do_not_shift_the_pose(room, circle) -> None:
    localizer = new_localizer(room)
    localizer.start_at(circle[0], 0.1, 0.05)
    rng, odometer = np.random.default_rng(3), WornOdometer()
    for index, pose in enumerate(circle):
        points = room.scan(pose, rng)
        points[70:110] *= 0.5 / np.linalg.norm(points[70:110], axis=1, keepdims=True)
        step = circle[index - 1].between(pose) if index else Pose(0, 0, 0)
        estimate = localizer.update(0.1 * index, odometer.count(step), points)
        assert error(estimate.pose, pose)[0] < 0.15
    assert estimate.health is Health.LOCALIZED


def test_global_search_localizes_anywhere_in_the_room(room, circle) -> None:
    localizer = new_localizer(room)
    localizer.start_anywhere()
    estimates = track(localizer, room, circle)
    assert estimates[0].health is Health.LOST
    sure = [i for i, e in enumerate(estimates) if e.health is Health.LOCALIZED]
    assert sure
    assert all(error(estimates[i].pose, circle[i])[0] < 0.1 for i in sure)
    assert estimates[-1].particle_count < 600


def test_kidnapped_robot_is_detected_and_relocalized(room, circle) -> None:
    localizer = new_localizer(room)
    localizer.start_at(circle[0], 0.1, 0.05)
    elsewhere = [Pose(2.5, 2.6, 2.5).compose(circle[0].between(pose)) for pose in circle[:120]]
    rng, odometry = np.random.default_rng(4), Pose(0, 0, 0)
    healths = []
    path = circle[:30] + elsewhere
    for index, pose in enumerate(path):
        if index and index != 30:  # the odometer does not see the robot being carried
            odometry = odometry.compose(path[index - 1].between(pose))
        estimate = localizer.update(0.1 * index, odometry, room.scan(pose, rng))
        healths.append(estimate.health)
    assert healths[29] is Health.LOCALIZED
    assert Health.LOST in healths[30:]
    assert healths[-1] is Health.LOCALIZED
    assert error(estimate.pose, path[-1])[0] < 0.05


def test_pose_survives_a_crowd_that_occludes_the_map(room, circle) -> None:
    """People occlude the walls for so long that a search starts; then they leave."""
    localizer = new_localizer(room)
    localizer.start_at(circle[0], 0.1, 0.05)
    rng, odometer, healths = np.random.default_rng(6), WornOdometer(), []
    for index, pose in enumerate(circle[:100]):
        points = room.scan(pose, rng)
        if 40 <= index < 60:
            points *= rng.uniform(0.2, 0.7, (len(points), 1))
        step = circle[index - 1].between(pose) if index else Pose(0, 0, 0)
        estimate = localizer.update(0.1 * index, odometer.count(step), points)
        healths.append(estimate.health)
    assert Health.LOST in healths[40:60]
    assert healths[-1] is Health.LOCALIZED
    assert error(estimate.pose, circle[99])[0] < 0.05


def test_blind_scans_make_the_pose_unsure(room, circle) -> None:
    localizer = new_localizer(room)
    localizer.start_at(circle[0], 0.05, 0.02)
    track(localizer, room, circle[:20])
    last = localizer.estimate
    for index in range(10):
        estimate = localizer.update(10.0 + index, last.odometry, np.empty((0, 2)))
    assert estimate.health is Health.UNSURE
    assert error(estimate.pose, last.pose)[0] < 0.1


def test_global_start_on_a_map_without_floor_raises() -> None:
    cells = np.ones((10, 10), dtype=np.uint8)
    localizer = Localizer(
        LocalizationSettings(),
        OccupancyMap(cells, 0.1, Pose(0, 0, 0)),
        np.random.default_rng(0),
    )
    with pytest.raises(MapError, match="free floor"):
        localizer.start_anywhere()


def test_real_log_with_a_poor_odometer_is_tracked(data_folder: Path) -> None:
    """The first 150 scans of the Intel Research Lab, on a map built from every other scan."""
    log = read_carmen(data_folder / "logs" / "intel-corrected.log.gz")
    occupancy = build_map(log, scans="even").map
    for seed in (1, 2):
        localizer = Localizer(LocalizationSettings(), occupancy, np.random.default_rng(seed))
        localizer.start_at(log.scans[0].reference, 0.1, 0.05)
        errors = []
        for scan in log.scans[:150]:
            estimate = localizer.update(scan.t, scan.odometry, scan.points())
            errors.append(error(estimate.pose, scan.reference))
        position, heading = np.array(errors).T
        assert np.median(position) < 0.05
        assert np.sqrt(np.mean(position**2)) < 0.06
        assert np.sqrt(np.mean(heading**2)) < 1.0
        assert position.max() < 0.4
        assert estimate.health is Health.LOCALIZED


def test_robot_pushed_aside_is_relocalized_nearby(room, circle) -> None:
    """Pushed 0.6 m and turned 20 degrees between two scans, its odometer standing still."""
    localizer = new_localizer(room)
    localizer.start_at(circle[0], 0.05, 0.02)
    rng = np.random.default_rng(2)
    for index in range(20):
        localizer.update(0.1 * index, Pose(0, 0, 0), room.scan(circle[0], rng))
    truth = circle[0].compose(Pose(-0.4, 0.45, math.radians(20)))
    estimate = localizer.update(2.0, Pose(0, 0, 0), room.scan(truth, rng))
    assert error(estimate.pose, truth)[0] < 0.05
    assert error(estimate.pose, truth)[1] < 1.0
    for index in range(21, 40):
        estimate = localizer.update(0.1 * index, Pose(0, 0, 0), room.scan(truth, rng))
    assert estimate.health is Health.LOCALIZED
    assert error(estimate.pose, truth)[0] < 0.03


def test_lasting_slip_is_tracked(room) -> None:
    """Wheels that lose 30 % over 4 m of steps of half a metre."""
    localizer = new_localizer(room)
    truth = Pose(1.0, 2.5, -0.1)
    localizer.start_at(truth, 0.05, 0.02)
    rng, odometry = np.random.default_rng(3), Pose(0, 0, 0)
    localizer.update(0.0, odometry, room.scan(truth, rng))
    for index in range(1, 9):
        truth = truth.compose(Pose(0.5, 0, 0))
        odometry = odometry.compose(Pose(0.5 / 0.7, 0, 0))
        estimate = localizer.update(float(index), odometry, room.scan(truth, rng))
        assert error(estimate.pose, truth)[0] < 0.1
    assert estimate.health is Health.LOCALIZED


def test_slip_in_a_bare_corridor_is_corrected_at_once(corridor) -> None:
    """Wheels lose 30 % over steps of a metre, where only the far ends are informative."""
    localizer = new_localizer(corridor)
    truth, odometry = Pose(3.0, 1.0, 0.0), Pose(0, 0, 0)
    localizer.start_at(truth, 0.05, 0.02)
    rng = np.random.default_rng(3)
    localizer.update(0.0, odometry, corridor.scan(truth, rng))
    for index in range(1, 11):
        truth = truth.compose(Pose(1.0, 0, 0))
        odometry = odometry.compose(Pose(1.0 / 0.7, 0, 0))
        estimate = localizer.update(float(index), odometry, corridor.scan(truth, rng))
        assert error(estimate.pose, truth)[0] < 0.3
    assert estimate.health is not Health.LOST


def test_board_before_a_standing_robot_does_not_shift_the_pose(room) -> None:
    """A board of 1.6 m that looks like a wall is set down, and taken away again."""
    truth, rng = Pose(3.0, 2.0, 0.4), np.random.default_rng(3)
    localizer = new_localizer(room)
    localizer.start_at(truth, 0.1, 0.05)
    for index in range(60):
        points = room.scan(truth, rng)
        if 20 <= index < 50:
            bearing = np.arctan2(points[:, 1], points[:, 0])
            on_board = np.abs(bearing) < math.atan2(0.8, 0.6)
            points[on_board] = np.column_stack(
                (np.full(on_board.sum(), 0.6), 0.6 * np.tan(bearing[on_board]))
            )
        estimate = localizer.update(0.1 * index, Pose(0, 0, 0), points)
        assert error(estimate.pose, truth)[0] < 0.1
        if index >= 20:
            assert estimate.health is Health.LOCALIZED


def crowded(points, rng, share: float):
    """End points of a scan with people of 0.44 m at 0.6 to 2.5 m before a share of its beams."""
    bearing, length = np.arctan2(points[:, 1], points[:, 0]), np.linalg.norm(points, axis=1)
    hidden = np.zeros(len(points), dtype=bool)
    while hidden.mean() < share:
        away, where = rng.uniform(0.6, 2.5), rng.uniform(-math.pi / 2, math.pi / 2)
        on_person = np.abs(bearing - where) < math.asin(0.22 / away)
        length = np.where(on_person, np.minimum(length, away), length)
        hidden |= on_person
    return length[:, None] * np.column_stack((np.cos(bearing), np.sin(bearing)))


@pytest.mark.parametrize("share", [0.2, 0.4, 0.6])
def test_pose_is_kept_in_a_crowd_that_stays(room, circle, share: float) -> None:
    localizer = new_localizer(room)
    localizer.start_at(circle[0], 0.1, 0.05)
    rng, odometer = np.random.default_rng(8), WornOdometer()
    errors = []
    for index, pose in enumerate(circle[::2]):
        step = circle[2 * index - 2].between(pose) if index else Pose(0, 0, 0)
        points = crowded(room.scan(pose, rng), rng, share if index > 5 else 0.0)
        estimate = localizer.update(0.1 * index, odometer.count(step), points)
        errors.append(error(estimate.pose, pose)[0])
    assert max(errors) < 0.5
    assert errors[-1] < 0.2
    for index in range(20):
        points = room.scan(pose, rng)
        estimate = localizer.update(20.0 + 0.1 * index, estimate.odometry, points)
    assert estimate.health is Health.LOCALIZED
    assert error(estimate.pose, pose)[0] < 0.05


def test_pose_is_kept_along_a_corridor_where_most_beams_end_short(data_folder: Path) -> None:
    """60 % of the beams of 26 scans of the Intel Research Lab, others at each scan."""
    log = read_carmen(data_folder / "logs" / "intel-corrected.log.gz")
    steps = Occlusion(0.6, by_people=False).of(log_steps(log))[680:706]
    localizer = Localizer(LocalizationSettings(), build_map(log).map, np.random.default_rng(5))
    localizer.start_at(log.scans[680].reference, 0.1, 0.05)
    for step in steps:
        estimate = localizer.update(step.t, step.odometry, step.points)
        assert step.reference is not None
        assert error(estimate.pose, step.reference)[0] < 0.5


@pytest.mark.parametrize(("name", "first"), [("seattle", 27), ("intel", 0)])
def test_pose_is_kept_in_a_dense_crowd(data_folder: Path, name: str, first: int) -> None:
    """Other people before 60 % of the beams at each scan; by ends alone wrong poses fit better."""
    log = read_carmen(data_folder / "logs" / f"{name}-corrected.log.gz")
    steps = Occlusion(0.6, by_people=True).of(log_steps(log))[first : first + 30]
    localizer = Localizer(LocalizationSettings(), build_map(log).map, np.random.default_rng(0))
    localizer.start_at(log.scans[first].reference, 0.1, 0.05)
    for step in steps:
        estimate = localizer.update(step.t, step.odometry, step.points)
        assert step.reference is not None
        assert error(estimate.pose, step.reference)[0] < 1.0


@pytest.mark.parametrize("degrees", [-90, 50, 75])
def test_turn_that_the_wheels_missed_is_found_whatever_its_size(room, circle, degrees) -> None:
    localizer = new_localizer(room)
    localizer.start_at(circle[0], 0.05, 0.02)
    rng = np.random.default_rng(2)
    for index in range(20):
        localizer.update(0.1 * index, Pose(0, 0, 0), room.scan(circle[0], rng))
    truth = circle[0].compose(Pose(0.0, 0.0, math.radians(degrees)))
    for index in range(20, 40):
        estimate = localizer.update(0.1 * index, Pose(0, 0, 0), room.scan(truth, rng))
        assert error(estimate.pose, truth)[0] < 0.1
    assert estimate.health is Health.LOCALIZED
