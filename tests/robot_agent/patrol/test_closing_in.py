"""Coming closer to teammates that send a robot back at one place again and again."""

import math
from pathlib import Path

import numpy as np
import pytest

from maps.border import Border
from maps.border_primitives import Arc, Segment
from maps.map_folder import load_map_folder
from maps.pose import Pose
from robot_agent.config import parse_config
from robot_agent.patrol.actions import Action
from robot_agent.patrol.closing_in import ClosingIn
from robot_agent.patrol.neighbor_state import NeighborView
from robot_agent.patrol.patrol import Patrol
from robot_agent.patrol.settings import PatrolSettings
from tools.bench.bench_fault import draw_faults
from tools.bench.ideal_fleet import IdealFleet, run_ideal_bench

CIRCLE = Border([Arc((0.0, 0.0), 6.0, math.pi, -math.tau)], closed=True)
LINE = Border([Segment((0.0, 0.0), (20.0, 0.0))], closed=False)
AHEAD = NeighborView(1.5, 1.0)


def closing_in(places, probability=1.0, direction=1):
    """What remembers being sent back from direction at places, m."""
    memory = ClosingIn(CIRCLE, np.random.default_rng(1), probability, 4.0)
    for place in places:
        memory.sent_back(0.0, place, direction)
    return memory


def test_who_was_sent_back_thrice_at_one_place_is_told_of_more_room():
    memory = closing_in([10.0, 10.3, 9.9])
    distances = [memory.told(NeighborView(d, 1.0), 1).distance for d in (0.5, 1.1, 1.25, 1.4, 2.0)]
    assert distances == pytest.approx([1.1, 1.1, 1.5, 1.9, 2.2])


@pytest.mark.parametrize(
    "places", [[10.0, 10.0], [10.0, 10.0, 11.0], [11.0, 10.0, 10.0], [10.0, 11.0, 10.0, 10.0]]
)
def test_sent_back_less_often_or_elsewhere_it_is_told_what_is(places):
    assert closing_in(places).told(AHEAD, 1) is AHEAD


def test_the_place_may_lie_on_the_seam():
    assert closing_in([0.1, CIRCLE.length - 0.1, 0.1]).told(AHEAD, 1).distance > 1.9


def test_a_teammate_behind_or_far_off_or_beside_the_border_is_told_as_it_is():
    memory = closing_in([10.0] * 3)
    for view in (NeighborView(1.5, -1.0), NeighborView(2.4, 1.0), NeighborView(1.5, 0.0)):
        assert memory.told(view, 1) is view
    assert memory.told(AHEAD, -1) is AHEAD


def test_chance_decides_and_never_without_a_probability():
    found = []
    memory = ClosingIn(CIRCLE, np.random.default_rng(5), 0.5, 4.0)
    for _ in range(400):
        memory.sent_back(0.0, 10.0, -1)
        found.append(memory.told(NeighborView(1.5, -1.0), -1).distance > 1.5)
    assert 150 < sum(found) < 250
    assert closing_in([10.0] * 9, probability=0.0).told(AHEAD, 1) is AHEAD


def test_who_was_sent_back_thrice_waits_as_long_as_chance_has_it_but_avoids_at_once():
    waits = []
    for seed in range(50):
        memory = ClosingIn(CIRCLE, np.random.default_rng(seed), 0.5, 4.0)
        for t in (0.0, 30.0, 60.0):
            assert not memory.waits(t + 0.1, Action.PATROL_CLOCKWISE)
            memory.sent_back(t, 10.0, 1)
        times = [60.0 + k / 10.0 for k in range(50)]
        waits.append(sum(memory.waits(t, Action.PATROL_CLOCKWISE) for t in times) / 10.0)
        assert not any(memory.waits(t, Action.AVOID_TEAMMATE) for t in times)
    assert min(waits) < 0.5
    assert 3.5 < max(waits) <= 4.1


def test_without_a_probability_nobody_waits():
    assert not closing_in([10.0] * 3, probability=0.0).waits(0.0, Action.PATROL_CLOCKWISE)


def approach(robot, teammate_x, t=0.0):
    """Drive along +x to 10 m, where a teammate comes into sight; return the decision there."""
    for k in range(10):
        t += 0.1
        robot.step(t, Pose(9.0 + 0.1 * k, 0.0, 0.0), None)
    decision = robot.step(t + 0.6, Pose(10.0, 0.0, 0.0), (teammate_x, 0.0))
    robot.step(t + 1.2, Pose(9.0, 0.0, math.pi), (teammate_x, 0.0))
    for k in range(20):  # away, and sent back by somebody else
        robot.step(t + 2.0 + 0.1 * k, Pose(8.0, 0.0, math.pi), (6.5, 0.0))
    return decision, t + 4.5


def test_the_fourth_time_it_comes_on_slowly_past_the_place_where_it_turned():
    settings = PatrolSettings(reversal_probability=0.0, closing_in=1.0)
    robot, t, actions = Patrol(settings, LINE, np.random.default_rng(0)), 0.0, []
    for _ in range(3):
        decision, t = approach(robot, 11.7, t)
        actions.append(decision.action)
    assert actions == [Action.PATROL_COUNTER_CLOCKWISE] * 3
    decision, _ = approach(robot, 11.7, t)
    assert decision.action is Action.KEEP_GOING
    assert decision.closes_in
    assert decision.velocity == pytest.approx((0.2, 0.0))
    assert decision.distance_from_neighbor == pytest.approx(1.7)  # as it is


@pytest.mark.long
@pytest.mark.parametrize(("closing_in", "gaps"), [(0.0, True), (0.5, False)])
def test_among_wrecks_it_leaves_no_gap(closing_in, gaps):
    """Five of twenty robots die on 51 m; seed 4 of ``wrecks_20.toml``."""
    folder = load_map_folder(Path("maps/paper_lab"), "border")
    names = [f"robot{number}" for number in range(1, 21)]
    config = parse_config(f"[patrol]\nclosing_in = {closing_in}\n".encode(), "test")
    faults = draw_faults(["any5:dead@60..400"], names, 4)
    figures = run_ideal_bench(IdealFleet(folder, 20, 4, config, faults=faults), 900.0)
    assert figures["contacts"] == 0
    assert (figures["after_wrecks"]["undriven_m"] > 0.5) is gaps
    assert (figures["after_wrecks"]["laps"] or math.inf) <= 2.0 or gaps
