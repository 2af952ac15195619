"""One robot behind another at the same speed, in a corridor: what seems to stand ahead moves."""

from __future__ import annotations

from pathlib import Path

from maps.map_folder import load_map_folder
from maps.pose import Pose
from robot_agent.config import find_map
from tools.bench.fleet import Fleet


def test_a_robot_behind_a_teammate_does_not_take_its_scan_for_a_repeated_one() -> None:
    """The corridor's walls show no travel along it, and the teammate ahead seems to stand."""
    folder = load_map_folder(find_map("paper_lab", Path()), "border")
    fleet = Fleet(folder, 2, 1, starts=[Pose(4.6, 3.76, 0.0), Pose(6.9, 3.76, 0.0)])
    while fleet.t < 16.0:
        fleet.step()
    for robot in fleet.robots:
        assert robot.agent.pose_tracker.travel.fault is None
        assert robot.agent.pose_tracker.trusted
    assert fleet.robots[0].rig.body.pose.x > 8.0, "it followed"
