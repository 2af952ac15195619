"""Walls just passed, as the laser saw them."""

import math

import numpy as np
import pytest

from maps.occupancy_map import FREE, OCCUPIED, OccupancyMap
from maps.pose import Pose
from robot_agent.motion.gate_settings import GateSettings
from robot_agent.passed_walls import PassedWalls
from robot_agent.scan_points import move_points

POSTS = np.array([(2.0, 1.55), (2.0, 2.45)])  # of a door in a wall at x = 2 m; map frame
ODOM_FROM_MAP = Pose(-7.0, 3.0, 1.1)


@pytest.fixture
def walls() -> PassedWalls:
    """Free from 0 to 4 m both ways, with a wall across at x = 2 to 2.1 m and a door of 0.9 m."""
    cells = np.full((80, 80), FREE, dtype=np.uint8)
    cells[:, 40:42] = OCCUPIED
    cells[31:49, 40:42] = FREE
    return PassedWalls(OccupancyMap(cells, 0.05, Pose(0.0, 0.0, 0.0)), GateSettings())


def drive(walls, xs, *, error=0.0, seen=POSTS, y=2.0, lost_at=math.inf):
    """Drive along +x past places xs, m, seeing points ahead only; error: of the pose's y, m."""
    for x in xs:
        pose = Pose(x, y, 0.0)
        ahead = move_points(seen, pose.inverse())
        ahead = ahead[ahead[:, 0] >= 0.0]
        believed = None if x >= lost_at else Pose(x, y + error, 0.0)
        walls.see(ODOM_FROM_MAP.compose(pose), believed, ahead)
    return ODOM_FROM_MAP.compose(Pose(xs[-1], y, 0.0))


def test_what_was_passed_is_where_it_was_seen_however_the_pose_errs(walls):
    odometry = drive(walls, np.arange(1.0, 2.1, 0.05), error=0.1)
    found = np.unique(walls.behind(odometry).round(3), axis=0)
    assert found == pytest.approx(np.array([(-0.05, -0.45), (-0.05, 0.45)]))


def test_ahead_it_tells_nothing_the_laser_looks_there(walls):
    assert not len(walls.behind(drive(walls, np.arange(1.0, 1.9, 0.05))))


def test_it_turns_with_the_robot(walls):
    odometry = drive(walls, np.arange(1.0, 2.05, 0.05))
    turned = odometry.compose(Pose(0.0, 0.0, -math.pi / 2))  # the left post is behind now
    found = np.unique(walls.behind(turned).round(3), axis=0)
    assert found == pytest.approx(np.array([(-0.45, 0.0)]))


def test_what_is_no_wall_of_the_map_may_have_walked_on(walls):
    person = np.array([(1.5, 2.4)])
    assert not len(walls.behind(drive(walls, np.arange(1.0, 1.7, 0.05), seen=person)))
    outside = np.array([(4.3, 2.4), (1.5, -0.2)])
    assert not len(walls.behind(drive(walls, np.arange(3.8, 4.5, 0.05), seen=outside)))


def test_what_the_body_would_stand_in_is_an_error(walls):
    odometry = drive(walls, np.arange(1.0, 2.1, 0.05), seen=np.array([(2.0, 2.2)]))
    assert not len(walls.behind(odometry))


def test_far_behind_it_is_forgotten(walls):
    """It backs to the door without having looked at it again."""
    near = [*np.arange(1.0, 2.1, 0.05), *np.arange(2.1, 2.5, 0.05), *np.arange(2.5, 2.08, -0.05)]
    assert len(walls.behind(drive(walls, near)))
    far = [*np.arange(2.1, 3.2, 0.05), *np.arange(3.2, 2.08, -0.05)]
    assert not len(walls.behind(drive(walls, far)))


def test_who_is_lost_knows_of_no_wall(walls):
    odometry = drive(walls, np.arange(1.0, 2.1, 0.05), lost_at=2.04)
    assert not len(walls.behind(odometry))


def test_standing_still_keeps_no_more(walls):
    odometry = drive(walls, [1.9] + [2.0] * 50)
    turned = odometry.compose(Pose(0.0, 0.0, -math.pi / 2))
    assert len(walls.behind(turned)) == 2  # of the left post, seen from two places
