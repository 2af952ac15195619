"""The modifier closing_in: after repeated turns at one place, a wait and a closer turning point."""

import math
from pathlib import Path

import numpy as np
import pytest

from maps.border import Border
from maps.border_primitives import Arc, Segment
from maps.map_folder import load_map_folder
from maps.pose import Pose
from robot_agent.config import parse_config
from robot_agent.patrol.actions import PATROL_DIRECTION, Action
from robot_agent.patrol.closing_in import ClosingIn
from robot_agent.patrol.modifier import OverrideReason
from robot_agent.patrol.neighbor_state import NO_NEIGHBOR, NeighborView
from robot_agent.patrol.patrol import Patrol
from robot_agent.patrol.rules import RULES_FILE, load_rules
from robot_agent.patrol.settings import PAPER_STRATEGY, PatrolSettings
from robot_agent.patrol.supervisor import Supervisor
from robot_agent.patrol.turn_log import Turn, TurnCause, TurnLog
from tests.robot_agent.patrol.situations import choice, situation
from tools.bench.bench_fault import draw_faults
from tools.bench.ideal_fleet import IdealFleet, run_ideal_bench

CIRCLE = Border([Arc((0.0, 0.0), 6.0, math.pi, -math.tau)], closed=True)
LINE = Border([Segment((0.0, 0.0), (20.0, 0.0))], closed=False)
AHEAD = NeighborView(1.5, 1.0)
ONWARD, BACK = Action.KEEP_GOING, Action.PATROL_COUNTER_CLOCKWISE


def rules():
    """The shipped rules, as the modifier evaluates them."""
    system = load_rules(RULES_FILE, reading="R1", safety_distance=2.4, open_border=False)
    return Supervisor(system, 0.0)


class Robot:
    """A robot on the circle with this modifier alone."""

    def __init__(self, probability=1.0, seed=1, border=CIRCLE):
        self.turns, self.t, self.border = TurnLog(), 0.0, border
        rng = np.random.default_rng(seed)
        self.modifier = ClosingIn(border, rules(), rules(), self.turns, rng, probability)

    def step(self, neighbor=NO_NEIGHBOR, *, at=10.0, direction=1):
        """Propose beside a teammate at an abscissa, m; the rules' turns are logged."""
        self.t += 10.0
        at_border = self.border.at(at)
        position = (at_border.x, at_border.y)
        now = situation(
            self.t, position, border=self.border, neighbor=neighbor, direction=direction
        )
        plain = choice(BACK if neighbor.distance < 1.9 else ONWARD)
        override = self.modifier.propose(now, plain, plain.winner)
        winner = plain.winner if override is None or override.action is None else override.action
        if PATROL_DIRECTION.get(winner) == -direction:
            turn = Turn(self.t, now.foot.abscissa, -direction, TurnCause.TEAMMATE)
            self.turns.add(turn)
        return override


def turned_at(places, **how):
    """A robot that teammates have turned back at these abscissae, m, one after the other."""
    robot = Robot(**how)
    for place in places:
        robot.step(AHEAD, at=place)
    return robot


def test_after_three_turns_at_one_place_approaches_slowly_to_1_4_m():
    robot = turned_at([10.0, 10.3, 9.9])
    for distance in (2.3, 2.0, 1.5):
        override = robot.step(NeighborView(distance, 1.0))
        assert (override.reason, override.action) == (OverrideReason.CLOSING_IN, ONWARD)
        assert override.speed_limit == 0.2
    assert robot.step(NeighborView(1.35, 1.0)).action is BACK
    near = turned_at([10.0] * 3).step(NeighborView(0.8, 1.0))
    assert near.action is Action.AVOID_TEAMMATE


@pytest.mark.parametrize(
    "places", [[10.0, 10.0], [10.0, 10.0, 11.0], [11.0, 10.0, 10.0], [10.0, 11.0, 10.0, 10.0]]
)
def test_fewer_turns_or_turns_elsewhere_change_nothing(places):
    assert turned_at(places).step(NeighborView(2.0, 1.0)) is None


def test_turns_on_both_sides_of_the_seam_count_as_one_place():
    robot = turned_at([0.1, CIRCLE.length - 0.1, 0.1])
    assert robot.step(NeighborView(2.0, 1.0)).reason is OverrideReason.CLOSING_IN


def test_teammate_behind_far_away_or_off_the_border_changes_nothing():
    robot = turned_at([10.0] * 3)
    for view in (NeighborView(2.0, -1.0), NeighborView(2.4, 1.0), NeighborView(2.0, 0.0)):
        assert robot.step(view) is None
    assert robot.step(NeighborView(2.0, 1.0), direction=-1) is None


def test_closes_in_with_the_given_probability():
    closes = [turned_at([10.0] * 3, probability=0.5, seed=seed) for seed in range(200)]
    count = sum(robot.step(NeighborView(2.0, 1.0)) is not None for robot in closes)
    assert 70 < count < 130
    assert turned_at([10.0] * 9, probability=0.0).step(NeighborView(2.0, 1.0)) is None


def test_waits_a_random_time_after_three_turns_at_one_place():
    waits = []
    for seed in range(50):
        robot = turned_at([10.0] * 2, seed=seed)
        robot.step(AHEAD)
        begun, waited = robot.t, 0.0
        for k in range(50):
            robot.t = begun - 10.0 + k / 10.0
            override = robot.step(NO_NEIGHBOR, direction=-1)
            waiting = override is not None and override.reason is OverrideReason.WAIT
            assert not waiting or override.speed_limit == 0.0
            waited += 0.1 * waiting
        waits.append(waited)
        robot.t = begun - 10.0
        avoiding = robot.step(NeighborView(0.6, 1.0), direction=-1)
        assert avoiding is None or avoiding.reason is not OverrideReason.WAIT
    assert min(waits) < 0.5
    assert 3.5 < max(waits) <= 4.1


def heads():
    """A random generator whose first draw for closing in succeeds."""
    return next(np.random.default_rng(seed) for seed in range(99) if _third_draw(seed) < 0.5)


def _third_draw(seed):
    """The draw for closing in, after that of the reversal's phase."""
    rng = np.random.default_rng(seed)
    rng.uniform(0.0, 27.0)
    return rng.random()


def approach(robot, teammate_x, t=0.0):
    """Drive along +x to 10 m, where a teammate comes into sight; return the decision there."""
    for k in range(10):
        t += 0.1
        robot.step(t, Pose(9.0 + 0.1 * k, 0.0, 0.0), None)
    decision = robot.step(t + 0.6, Pose(10.0, 0.0, 0.0), (teammate_x, 0.0))
    robot.step(t + 1.2, Pose(9.0, 0.0, math.pi), (teammate_x, 0.0))
    for k in range(20):  # away, and turned back by another teammate
        robot.step(t + 2.0 + 0.1 * k, Pose(8.0, 0.0, math.pi), (6.5, 0.0))
    return decision, t + 4.5


def test_fourth_approach_passes_the_turning_point_slowly():
    settings = PatrolSettings(reversal_probability=0.0)
    robot, t, actions = Patrol(settings, LINE, heads()), 0.0, []
    for _ in range(3):
        decision, t = approach(robot, 11.7, t)
        actions.append(decision.action)
    assert actions == [Action.PATROL_COUNTER_CLOCKWISE] * 3
    decision, _ = approach(robot, 11.7, t)
    assert decision.action is Action.KEEP_GOING
    assert decision.override is OverrideReason.CLOSING_IN
    assert decision.velocity == pytest.approx((0.2, 0.0))
    assert decision.distance_from_neighbor == pytest.approx(1.7)  # as it is


@pytest.mark.long
@pytest.mark.parametrize(("off", "gaps"), [("closing_in", True), ("", False)])
def test_among_wrecks_no_gap_stays_undriven(off, gaps):
    """Five of twenty robots fail on 51 m; seed 4 of ``wrecks_20.toml``."""
    folder = load_map_folder(Path("maps/paper_lab"), "border")
    names = [f"robot{number}" for number in range(1, 21)]
    modifiers = [name for name in PAPER_STRATEGY if name != off]
    config = parse_config(f"[patrol]\nmodifiers = {modifiers}\n".encode(), "test")
    faults = draw_faults(["any5:dead@60..400"], names, 4)
    figures = run_ideal_bench(IdealFleet(folder, 20, 4, config, faults=faults), 900.0)
    assert figures["contacts"] == 0
    assert (figures["after_wrecks"]["undriven_m"] > 0.5) is gaps
    assert (figures["after_wrecks"]["laps"] or math.inf) <= 2.0 or gaps
