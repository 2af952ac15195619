"""Standing off beside the border: a while, and then one insists."""

import math
from pathlib import Path

import pytest

from maps.border import Border
from maps.border_primitives import Segment
from maps.map_folder import load_map_folder
from maps.pose import Pose
from robot_agent.config import find_map
from robot_agent.patrol.actions import Action
from robot_agent.patrol.modifier import OverrideReason
from robot_agent.patrol.standoff import Standoff
from tests.robot_agent.patrol.event_log import EventLog
from tests.robot_agent.patrol.situations import choice, situation
from tools.bench.fleet import Fleet
from tools.simulation.robot_body import Outline

AVOID, REACH, PATROL = Action.AVOID_TEAMMATE, Action.REACH_FRONTIER, Action.PATROL_CLOCKWISE


class Robot:
    """A robot that only insists."""

    def __init__(self):
        self.standoff = Standoff()

    def insists_on(self, t, place, way, action, out=None):
        """What it insists on at a place so many metres from the border; out: caught at an end."""
        line = Border([Segment((-100.0, place[1] - way), (100.0, place[1] - way))], closed=False)
        ends = (math.inf, math.inf) if out is None else (0.2, 19.8)
        now = situation(t, place, border=line, ends=ends)
        override = self.standoff.propose(now, choice(action, caught=out is not None), action)
        return None if override is None else override.action


def insisting(places, action=AVOID, way=1.2):
    """The times, s, of ten steps a second at these places at which the robot insists."""
    standoff = Robot()
    times = [k / 10.0 for k in range(len(places))]
    found = zip(times, places, strict=True)
    return [t for t, place in found if standoff.insists_on(t, place, way, action)]


@pytest.mark.parametrize("action", [AVOID, PATROL, Action.KEEP_GOING])
def test_insists_after_standing_about_for_a_while_and_then_waits_again(action):
    wandering = [(0.1 * math.sin(k / 7.0), 0.0) for k in range(500)]
    times = insisting(wandering, action)
    assert times[0] == pytest.approx(12.0, abs=0.11)
    assert len([t for t in times if t < 30.0]) == pytest.approx(80, abs=1)
    again = next(t for t in times if t > 25.0)
    assert again == pytest.approx(12.0 + 8.0 + 12.0, abs=0.3)


def test_somebody_who_gets_on_does_not_insist():
    assert insisting([(k / 50.0, 0.0) for k in range(500)], PATROL) == []


def test_avoiding_all_the_time_ends_wherever_it_leads():
    times = insisting([(k / 50.0, 0.0) for k in range(300)])
    assert times[0] == pytest.approx(20.0)


def test_on_the_border_and_on_the_way_to_it_there_is_nothing_to_insist_on():
    assert insisting([(0.0, 0.0)] * 500, PATROL, way=0.25) == []
    assert insisting([(0.0, 0.0)] * 500, REACH) == []


def test_what_it_insists_on_is_the_border_beside_it_and_the_patrol_on_it():
    at, beside, on = (0.0, 0.0), Robot(), Robot()
    found = [
        {standoff.insists_on(k / 10.0, at, way, AVOID) for k in range(250)}
        for standoff, way in ((beside, 1.2), (on, 0.25))
    ]
    assert found == [{None, REACH}, {None, Action.KEEP_GOING}]


def test_caught_on_the_border_it_takes_the_way_out_after_a_while():
    standoff, at = Robot(), (0.0, 0.0)
    found = [standoff.insists_on(k / 10.0, at, 0.1, PATROL, PATROL) for k in range(250)]
    times = [k / 10.0 for k, insisted in enumerate(found) if insisted]
    assert times == pytest.approx([12.0 + k / 10.0 for k in range(80)])
    assert set(found) == {None, PATROL}


def test_on_its_way_out_it_avoids_who_stands_there():
    standoff, at = Robot(), (0.0, 0.0)
    for k in range(125):
        standoff.insists_on(k / 10.0, at, 0.1, PATROL, PATROL)
    assert standoff.insists_on(12.5, at, 0.1, AVOID) is None
    assert standoff.insists_on(12.6, at, 0.1, PATROL, PATROL) is None


def test_on_the_border_only_long_avoiding_ends():
    times = insisting([(0.0, 0.0)] * 600, AVOID, way=0.25)
    assert [t for t in times if t < 48.0] == pytest.approx([20.0 + k / 10.0 for k in range(80)])
    assert next(t for t in times if t > 28.0) == pytest.approx(48.0, abs=0.11)


def test_crossing_to_the_border_and_back_does_not_begin_the_count_of_avoiding_anew():
    standoff = Robot()
    ways = [0.25 + 0.1 * (k % 40 < 20) for k in range(210)]
    insists = [standoff.insists_on(k / 10.0, (0.0, 0.0), way, AVOID) for k, way in enumerate(ways)]
    assert insists.index(next(filter(None, insists))) == 200


def test_arriving_ends_it():
    standoff = Robot()
    at = (0.0, 0.0)
    assert [k for k in range(130) if standoff.insists_on(k / 10.0, at, 1.0, AVOID)]
    assert not standoff.insists_on(13.1, at, 0.2, AVOID)
    assert not standoff.insists_on(13.2, at, 1.0, AVOID)  # counts from the border on


def test_other_actions_between_begin_the_count_of_avoiding_anew():
    standoff, insists = Robot(), []
    for k in range(350):
        action = PATROL if k == 150 else AVOID
        insists.append(standoff.insists_on(k / 10.0, (k / 50.0, 0.0), 1.2, action))
    assert not any(insists[:350])


def test_a_robot_that_a_box_keeps_beside_the_border_goes_straight_there_and_says_so():
    """It keeps going along the border, 0.65 m beside it, and stands before the box on its way."""
    log, lab = EventLog(), load_map_folder(find_map("paper_lab", Path.cwd()))
    fleet = Fleet(lab, 1, 1, None, [Pose(5.5, 13.0, 0.0)], lambda *_: log)
    fleet.world.add_body(Pose(6.3, 13.2, 0.0), Outline(0.1, 0.1, 0.15))
    agent = fleet.robots[0].agent
    decisions = []
    while fleet.t < 24.0:
        fleet.step()
        decisions.append(agent.decision)
    decided = [decision for decision in decisions if decision is not None]
    insisting = [each for each in decided if each.override is OverrideReason.STANDOFF]
    nearest = min(each.distance_from_border for each in insisting)
    assert nearest < 0.35
    assert {decision.action for decision in insisting} == {REACH}
    assert {decision.raw_winner for decision in insisting} != {REACH}
    said = [line for _, line in log.lines if "kept from the border near s" in line]
    assert said
    assert fleet.world.contacts == 0
