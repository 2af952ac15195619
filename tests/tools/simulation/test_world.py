"""Bodies in the simulated world: motion, contacts, odometers, sensors."""

from __future__ import annotations

import math

import numpy as np
import pytest
from msgspec.structs import replace

from drivers.p2os.model import load_model
from maps.occupancy_map import FREE, OCCUPIED, OccupancyMap
from maps.pose import Pose
from tools.simulation.robot_body import RobotBody
from tools.simulation.truth.truth import load_truth
from tools.simulation.truth.world_noise import WorldNoise
from tools.simulation.world import Contact, World, plain_noise

NO_NOISE = load_truth("ideal").noise
MOUNT = (0.017, 0.008, 0.0)
LEFT_MOST, MIDDLE, RIGHT_MOST = 0b00001, 0b00100, 0b10000


@pytest.fixture(scope="module")
def hall() -> OccupancyMap:
    """Free from (0, 0) to (10, 6) m, one cell of wall around."""
    cells = np.full((122, 202), OCCUPIED, dtype=np.uint8)
    cells[1:-1, 1:-1] = FREE
    return OccupancyMap(cells=cells, resolution=0.05, origin=Pose(-0.05, -0.05, 0.0))


def world_of(hall: OccupancyMap, noise: WorldNoise = NO_NOISE, seed: int = 1) -> World:
    return World(hall, np.random.default_rng(seed), noise)


def test_free_body_moves_as_its_wheels_and_odometer(hall: OccupancyMap) -> None:
    world = world_of(hall)
    body = world.add_body(Pose(3.0, 3.0, 0.0))
    radius, steps = 1.0, 50
    for _ in range(steps):
        angle = math.pi / 2 / steps
        motion = world.move(body, radius * angle, angle)
        assert motion.odometer_distance == pytest.approx(radius * angle)
        assert motion.odometer_rotation == pytest.approx(angle)
        assert not motion.blocked
        assert not motion.touching
    assert body.pose == pytest.approx((4.0, 4.0, math.pi / 2))
    assert world.contacts == 0


def test_a_wall_ahead_stops_the_body_and_its_wheels_and_presses_the_front_bumpers(
    hall: OccupancyMap,
) -> None:
    world = world_of(hall)
    body = world.add_body(Pose(9.0, 3.0, 0.0))
    motions = [world.move(body, 0.03, 0.0) for _ in range(40)]
    assert body.pose.x == pytest.approx(10.0 - body.outline.front, abs=1e-3)
    counted = sum(motion.odometer_distance for motion in motions)
    assert counted == pytest.approx(1.0 - body.outline.front, abs=1e-3)
    assert motions[-1].blocked
    assert motions[-1].front_bumpers & MIDDLE
    assert motions[-1].rear_bumpers == 0
    assert not motions[0].touching
    assert world.contacts == 1
    assert world.contact_log == [Contact(0, None)]


def test_a_contact_is_counted_again_after_parting(hall: OccupancyMap) -> None:
    world = world_of(hall)
    body = world.add_body(Pose(9.7, 3.0, 0.0))
    for _ in range(3):
        while not world.move(body, 0.02, 0.0).blocked:
            pass
        world.move(body, -0.01, 0.0)
        assert not world.move(body, 0.0, 0.0).touching
        while not world.move(body, 0.02, 0.0).blocked:
            pass
        for _ in range(5):
            world.move(body, -0.02, 0.0)
    assert world.contacts == 3


def test_backing_into_a_wall_presses_the_rear_bumpers(hall: OccupancyMap) -> None:
    world = world_of(hall)
    body = world.add_body(Pose(0.4, 3.0, 0.0))
    for _ in range(10):
        motion = world.move(body, -0.03, 0.0)
    assert motion.blocked
    assert motion.front_bumpers == 0
    assert motion.rear_bumpers & MIDDLE


def test_a_corner_presses_the_bumper_of_its_side(hall: OccupancyMap) -> None:
    world = world_of(hall)
    body = world.add_body(Pose(9.5, 3.0, math.radians(35.0)))
    motion = world.move(body, 0.0, 0.0)
    while not motion.blocked:
        motion = world.move(body, 0.02, 0.0)
    # Heading up and to the right-hand wall, the front right corner arrives first.
    assert motion.front_bumpers & (RIGHT_MOST | RIGHT_MOST >> 1)
    assert not motion.front_bumpers & (LEFT_MOST | LEFT_MOST << 1)


def test_collision_is_one_contact_and_presses_both_bumpers(hall: OccupancyMap) -> None:
    world = world_of(hall)
    left, right = world.add_body(Pose(4.0, 3.0, 0.0)), world.add_body(Pose(6.0, 3.0, math.pi))
    for _ in range(60):
        first, second = world.move(left, 0.02, 0.0), world.move(right, 0.02, 0.0)
    assert right.pose.x - left.pose.x == pytest.approx(0.42, abs=2e-3)
    assert first.blocked
    assert second.blocked
    assert first.front_bumpers & MIDDLE
    assert second.front_bumpers & MIDDLE
    assert world.contact_log == [Contact(0, 1)]


def test_standing_robot_hit_from_behind_has_rear_bumpers_pressed(hall: OccupancyMap) -> None:
    world = world_of(hall)
    standing, driving = world.add_body(Pose(5.0, 3.0, 0.0)), world.add_body(Pose(3.5, 3.0, 0.0))
    for _ in range(60):
        felt = world.move(standing, 0.0, 0.0)
        world.move(driving, 0.03, 0.0)
    felt = world.move(standing, 0.0, 0.0)
    assert standing.pose == (5.0, 3.0, 0.0)
    assert felt.rear_bumpers & MIDDLE
    assert felt.front_bumpers == 0
    assert not felt.blocked
    assert world.contacts == 1


def test_a_robot_cannot_start_in_a_wall_or_in_another(hall: OccupancyMap) -> None:
    world = world_of(hall)
    world.add_body(Pose(3.0, 3.0, 0.0))
    for pose in (Pose(3.3, 3.2, 1.0), Pose(9.9, 3.0, 0.0), Pose(30.0, 3.0, 0.0)):
        with pytest.raises(ValueError, match="another start pose"):
            world.add_body(pose)
    assert len(world.bodies) == 1


def test_edge_of_the_map_is_blocked() -> None:
    cells = np.full((100, 100), FREE, dtype=np.uint8)
    world = world_of(OccupancyMap(cells=cells, resolution=0.05, origin=Pose(0.0, 0.0, 0.0)))
    body = world.add_body(Pose(4.0, 2.5, 0.0))
    for _ in range(60):
        world.move(body, 0.05, 0.0)
    assert body.pose.x == pytest.approx(5.0 - body.outline.front, abs=2e-3)


def odometer_errors(world: World, body: RobotBody) -> tuple[float, float]:
    """Drive 1 m forth and back twice; return the odometer's share of error and heading."""
    distance = rotation = 0.0
    for way in (0.02, -0.02) * 2:
        for _ in range(50):
            motion = world.move(body, way, 0.0)
            distance += abs(motion.odometer_distance)
            rotation += motion.odometer_rotation * math.copysign(1.0, way)
    return distance / 4.0 - 1.0, rotation / 4.0


def test_odometer_error_follows_each_wheels_scale(hall: OccupancyMap) -> None:
    noise = replace(
        plain_noise(),
        slip_distance=0.0,
        slip_rotation=0.0,
        slip_heading=0.0,
        wheel_scale=0.02,
        odometer=0.0,
    )
    shares = []
    for seed in range(40):
        world = world_of(hall, noise, seed)
        body = world.add_body(Pose(4.0, 3.0, 0.0))
        left, right = body.wheel_scales
        share, turned = odometer_errors(world, body)
        assert share == pytest.approx((left + right) / 2 - 1.0)
        assert turned == pytest.approx((right - left) / body.outline.track)
        shares.append(share)
    assert np.std(shares) == pytest.approx(0.02 / math.sqrt(2), rel=0.4)


@pytest.mark.parametrize("step", [0.01, 0.05])
def test_slip_is_independent_of_the_step_size(hall: OccupancyMap, step: float) -> None:
    ways = []
    for seed in range(120):
        world = world_of(hall, replace(plain_noise(), slip_distance=0.05, slip_heading=0.0), seed)
        body = world.add_body(Pose(4.0, 3.0, 0.0))
        for _ in range(round(1.0 / step)):
            world.move(body, step, 0.0)
        ways.append(body.pose.x - 4.0)
    assert np.mean(ways) == pytest.approx(1.0, abs=0.02)
    assert np.std(ways) == pytest.approx(0.05, rel=0.3)


def test_laser_ranges_walls_and_robots_from_its_mount(hall: OccupancyMap) -> None:
    world = world_of(hall)
    body = world.add_body(Pose(3.0, 2.0, math.pi / 2))
    world.add_body(Pose(3.0, 4.0, math.pi / 2))
    ranges = world.scan(body, body.pose, 181, math.radians(1.0), MOUNT)
    # Right-most beam first: towards +x, whose wall is at 10 m; the laser is 8 mm left of centre.
    assert ranges[0] == pytest.approx(7.0 + 0.008, abs=1e-3)
    assert ranges[90] == pytest.approx(2.0 - 0.301 - 0.017, abs=1e-3)
    assert ranges[180] == pytest.approx(3.0 - 0.008, abs=1e-3)
    moved = Pose(3.0, 1.5, math.pi / 2)
    assert world.scan(body, moved, 181, math.radians(1.0), MOUNT)[90] == pytest.approx(
        2.5 - 0.301 - 0.017, abs=1e-3
    )


def test_laser_noise_and_range_limit_match_the_settings(hall: OccupancyMap) -> None:
    exact = world_of(hall)
    noisy = world_of(hall, replace(plain_noise(), laser_dropouts=0.05))
    pose = Pose(3.0, 2.0, 0.4)
    truth = exact.scan(exact.add_body(pose), pose, 361, math.radians(0.5), MOUNT)
    body = noisy.add_body(pose)
    scans = np.array([noisy.scan(body, pose, 361, math.radians(0.5), MOUNT) for _ in range(30)])
    assert np.isinf(scans).mean() == pytest.approx(0.05, rel=0.2)
    errors = (scans - truth)[np.isfinite(scans)]
    assert errors.std() == pytest.approx(0.01, rel=0.1)
    exact.laser_max_range = 4.0
    far = exact.scan(exact.bodies[0], pose, 361, math.radians(0.5), MOUNT)
    assert np.isinf(far[truth > 4.0]).all()
    assert np.isfinite(far[truth <= 4.0]).all()


def test_sonar_returns_the_nearest_object_in_its_cone(hall: OccupancyMap) -> None:
    ring = load_model("p2dx").sonar
    world = world_of(hall)
    body = world.add_body(Pose(8.5, 3.0, 0.0))
    ranges = world.sonar(body, ring)
    assert len(ranges) == 16
    # Number 3 points 10 degrees left of the wall's normal: that normal lies in its cone.
    assert 1.3 < ranges[3] < 1.36
    assert ranges[3] == pytest.approx(ranges[4])
    assert ranges[0] == pytest.approx(3.0 - 0.136, abs=0.01)
    assert ranges[11] == 5.0
    world.add_body(Pose(7.0, 3.0, 0.0))
    assert world.sonar(body, ring)[11] == pytest.approx(1.5 - 0.255 - 0.210, abs=0.05)


def test_same_seed_gives_the_same_world(hall: OccupancyMap) -> None:
    def outcome() -> list[float]:
        world = world_of(hall, plain_noise(), seed=5)
        body, _ = world.add_body(Pose(3.0, 3.0, 0.3)), world.add_body(Pose(5.0, 3.0, 2.0))
        for _ in range(50):
            world.move(body, 0.01, 0.02)
        scan = world.scan(body, body.pose, 181, math.radians(1.0), MOUNT)
        return [*body.pose, *scan, *world.sonar(body, load_model("p2dx").sonar)]

    assert outcome() == outcome()
