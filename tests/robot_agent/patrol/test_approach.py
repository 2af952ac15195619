"""The approach round walls: decisions with a border behind a wall, and a run out of rooms."""

from pathlib import Path

import numpy as np
import pytest

from maps.map_folder import load_map_folder
from maps.pose import Pose
from robot_agent.patrol.actions import PATROLLING, Action
from robot_agent.patrol.patrol import Patrol
from robot_agent.patrol.settings import PatrolSettings
from tools.bench.fleet import Fleet

LAB = load_map_folder(Path(__file__).parents[3] / "maps" / "paper_lab")
assert LAB.border is not None


def decide(x, y, *, walls=True):
    patrol = Patrol(
        PatrolSettings(reversal_probability=0.0),
        LAB.border,
        np.random.default_rng(0),
        LAB.approach_field if walls else None,
    )
    return patrol.step(0.0, Pose(x, y, 0.0), None)


def test_border_behind_a_wall_is_reached_through_the_door():
    """1.5 m off the border in a straight line, but 2 m and more on the way through the door."""
    hidden = decide(5.4 + 0.4, 7.6)  # core room; the border is the west corridor's middle
    assert hidden.distance_from_border < 1.9
    assert hidden.way_to_border > 2.2
    assert hidden.action is Action.REACH_FRONTIER
    assert hidden.velocity[1] < -0.2  # along the wall to its door, not at the wall


def test_without_a_wall_between_the_decision_is_equation_6():
    for place in ((3.2, 9.0), (17.5, 10.9), (4.2, 13.2), (8.0, 14.5)):
        free, walled = decide(*place, walls=False), decide(*place)
        assert walled == free
        assert walled.way_to_border == walled.distance_from_border


def test_no_tangential_velocity_along_a_border_behind_a_wall():
    """With any action behind a wall, the velocity is that of the approach alone."""
    for x, y in ((2.3, 10.0), (2.0, 4.4), (8.0, 15.35), (12.4, 15.3)):
        decision = decide(x, y)
        if decision.way_to_border == decision.distance_from_border:
            continue
        assert np.hypot(*decision.velocity) <= 0.5
        if decision.action in PATROLLING:
            approach = LAB.approach_field.around_walls(x, y, LAB.border.at(decision.abscissa)[:2])
            speed = 0.3 * approach.distance
            assert decision.velocity == pytest.approx(
                (speed * approach.direction[0], speed * approach.direction[1])
            )


def test_robots_in_rooms_reach_the_border_through_the_doors():
    """Three rooms, one of them behind another room: full agents, no contact."""
    starts = [Pose(1.0, 1.3, -1.5), Pose(7.6, 9.2, 0.0), Pose(16.5, 7.8, 0.0)]
    for start in starts:
        foot = LAB.border.project(start.x, start.y)
        assert LAB.approach_field.around_walls(start.x, start.y, (foot.x, foot.y)) is not None
    fleet = Fleet(LAB, len(starts), seed=1, starts=starts)
    first_actions: dict[str, Action] = {}
    while fleet.t < 45.0:
        fleet.step()
        for robot in fleet.robots:
            if robot.agent.decision is not None:
                first_actions.setdefault(robot.rig.name, robot.agent.decision.action)
    assert set(first_actions.values()) == {Action.REACH_FRONTIER}
    assert fleet.world.contacts == 0
    for robot in fleet.robots:
        true = robot.rig.body.pose
        assert LAB.border.project(true.x, true.y).distance < 0.1
        assert robot.agent.decision.action in PATROLLING
