"""Interpolation between fixed poses."""

from __future__ import annotations

import pytest

from maps.pose import Pose
from tools.mapping.slam.rigid_fit import fit
from tools.mapping.slam.trajectory import Trajectory

# Straight by the odometry, while the robot turned; stamps out of order.
ODOMETRY = [
    (0.0, Pose(5.0, 5.0, 0.0)),
    (1.0, Pose(6.0, 5.0, 0.0)),
    (3.0, Pose(7.0, 5.0, 0.0)),
    (2.0, Pose(8.0, 5.0, 0.0)),
    (4.0, Pose(9.0, 5.0, 0.0)),
]
FIXED = {0: Pose(0.0, 0.0, 0.0), 4: Pose(4.0, 0.8, 0.4)}


def test_odometry_error_is_distributed_over_the_distance() -> None:
    poses = Trajectory(ODOMETRY, FIXED).poses
    assert poses[0] == FIXED[0]
    assert poses[1] == pytest.approx((1.0, 0.2, 0.1))
    assert poses[3] == pytest.approx((3.0, 0.6, 0.3))
    assert poses[4] == FIXED[4]


def test_pose_is_found_by_stamp_in_any_order() -> None:
    trajectory = Trajectory(ODOMETRY, FIXED)
    assert trajectory.at(2.0) == trajectory.poses[3]
    assert trajectory.at(3.0) == trajectory.poses[2]
    assert trajectory.at(0.5) == pytest.approx((0.5, 0.1, 0.05))
    assert trajectory.at(-0.1) is None
    assert trajectory.at(4.1) is None


def test_standing_robot_has_one_pose() -> None:
    still = [(float(t), Pose(1.0, 1.0, 1.0)) for t in range(3)]
    trajectory = Trajectory(still, {0: Pose(2.0, 0.0, 0.0), 2: Pose(2.0, 0.0, 0.0)})
    assert trajectory.at(1.0) == pytest.approx((2.0, 0.0, 0.0))


def test_rigid_fit_undoes_a_motion() -> None:
    motion = Pose(3.0, -7.0, 2.5)
    poses = [Pose(0.0, 0.0, 0.0), Pose(4.0, 1.0, 0.5), Pose(-2.0, 3.0, 1.0)]
    assert fit(poses, [motion.compose(pose) for pose in poses]) == pytest.approx(motion)
