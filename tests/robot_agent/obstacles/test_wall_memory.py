"""Memory of the walls just passed."""

import math

import numpy as np
import pytest

from maps.pose import Pose
from robot_agent.motion.gate_limits import GateLimits
from robot_agent.obstacles.wall_memory import WallMemory
from robot_agent.perception.scan_points import move_points

POSTS = np.array([(2.0, 1.55), (2.0, 2.45)])  # of a door in a wall at x = 2 m
ODOM_FROM_WORLD = Pose(-7.012, 3.031, 1.1)


@pytest.fixture
def walls() -> WallMemory:
    return WallMemory(GateLimits())


def drive(walls, xs, *, seen=POSTS, noise=0.0):
    """Drive along +x past places xs, m, at y = 2 m, seeing walls ahead only; return odometry."""
    rng = np.random.default_rng(3)
    for x in xs:
        pose = Pose(x, 2.0, 0.0)
        ahead = move_points(seen, pose.inverse())
        ahead = ahead[ahead[:, 0] >= 0.0]
        walls.update(
            ODOM_FROM_WORLD.compose(pose), ahead + noise * rng.standard_normal(ahead.shape)
        )
    return ODOM_FROM_WORLD.compose(Pose(xs[-1], 2.0, 0.0))


def test_passed_wall_is_where_it_was_measured(walls):
    odometry = drive(walls, np.arange(1.0, 2.1, 0.05))
    found = walls.around(odometry)
    assert found[found[:, 1].argsort()] == pytest.approx(np.array([(-0.05, -0.45), (-0.05, 0.45)]))


def test_points_turn_with_the_robot(walls):
    odometry = drive(walls, np.arange(1.0, 2.05, 0.05))
    turned = odometry.compose(Pose(0.0, 0.0, -math.pi / 2))  # the left post is behind now
    found = walls.around(turned)
    expected = np.array([(-0.45, 0.0), (0.45, 0.0)])
    assert found[found[:, 0].argsort()] == pytest.approx(expected, abs=1e-9)


def test_noise_does_not_bring_a_wall_nearer(walls):
    side = np.column_stack((np.arange(0.0, 3.0, 0.01), np.full(300, 2.35)))
    odometry = drive(walls, np.arange(1.0, 2.1, 0.05), seen=side, noise=0.01)
    found = walls.around(odometry)
    assert len(found) > 5
    assert found[:, 1].min() > 0.335


def test_cells_with_too_few_points_are_dropped(walls):
    assert not len(walls.around(drive(walls, [1.9, 1.95, 2.05])))


def test_points_inside_the_footprint_are_left_out(walls):
    odometry = drive(walls, np.arange(1.0, 2.1, 0.05), seen=np.array([(2.0, 2.2)]))
    assert not len(walls.around(odometry))


def test_scans_farther_back_than_the_kept_way_are_dropped(walls):
    """The robot returns backwards to the door, which has not been in view again."""
    near = [*np.arange(1.0, 2.1, 0.05), *np.arange(2.1, 2.5, 0.05), *np.arange(2.5, 2.08, -0.05)]
    assert len(walls.around(drive(walls, near)))
    far = [*np.arange(2.1, 3.2, 0.05), *np.arange(3.2, 2.08, -0.05)]
    assert not len(walls.around(drive(walls, far)))


def test_forget_drops_all_walls(walls):
    odometry = drive(walls, np.arange(1.0, 2.1, 0.05))
    walls.forget()
    assert not len(walls.around(odometry))


def test_scans_at_standstill_are_kept_once(walls):
    assert not len(walls.around(drive(walls, [1.9, 1.95] + [1.951] * 50 + [2.05])))
