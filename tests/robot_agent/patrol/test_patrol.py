"""One robot's decisions: velocities, direction memory, reversal, ends of an open border."""

import math
from itertools import pairwise

import numpy as np
import pytest

from maps.border import Border, BorderError
from maps.border_primitives import Arc, Segment
from maps.pose import Pose
from robot_agent.patrol.actions import Action, action_velocity
from robot_agent.patrol.modifier import OverrideReason
from robot_agent.patrol.neighbor_state import NO_NEIGHBOR
from robot_agent.patrol.patrol import Patrol
from robot_agent.patrol.rules import RulesError
from robot_agent.patrol.settings import DEFAULT_MODIFIERS, PatrolSettings
from robot_agent.patrol.situation import Situation
from robot_agent.patrol.turn_log import TurnCause

CIRCLE = Border([Arc((0.0, 0.0), 6.0, math.pi, -math.tau)], closed=True)  # clockwise from -x
LINE = Border([Segment((0.0, 0.0), (20.0, 0.0))], closed=False)  # +s is +x


def patrol(border=CIRCLE, *, seed=0, **settings):
    settings = {"reversal_probability": 0.0} | settings
    return Patrol(PatrolSettings(**settings), border, np.random.default_rng(seed))


def on_circle(angle, *, heading=1, outward=0.0):
    """Pose at an angle seen from the centre; heading +1 clockwise, -1 counter-clockwise."""
    r = 6.0 + outward
    return Pose(r * math.cos(angle), r * math.sin(angle), angle - heading * math.pi / 2)


def test_far_from_the_border_reaches_it_at_the_speed_limit():
    decision = patrol().step(0.0, Pose(10.0, 0.0, 0.0), None)
    assert decision.action is Action.REACH_FRONTIER
    assert decision.velocity == pytest.approx((-0.5, 0.0))
    assert decision.distance_from_border == pytest.approx(4.0)
    assert decision.curvature == 0.0


@pytest.mark.parametrize("heading", [1, -1])
def test_first_direction_is_that_of_the_heading(heading):
    decision = patrol().step(0.0, on_circle(0.0, heading=heading), None)
    assert decision.action is Action.KEEP_GOING
    assert decision.direction == heading
    assert decision.velocity == pytest.approx((0.0, -0.35 * heading), abs=1e-9)
    # clockwise turns right
    assert decision.curvature == pytest.approx(-heading / 6.0)


def test_keep_going_beside_the_border_is_equation_11():
    decision = patrol().step(0.0, on_circle(0.0, outward=0.2), None)
    assert decision.velocity == pytest.approx((-0.06, -0.35))


def test_direction_is_kept_when_the_heading_changes():
    robot = patrol()
    robot.step(0.0, on_circle(0.0, heading=-1), None)
    assert robot.step(0.1, on_circle(0.0, heading=1), None).direction == -1


def at_distance(distance, side):
    """A teammate on the circle, distance m (straight) ahead in the sense of side."""
    angle = -side * 2.0 * math.asin(distance / 12.0)
    return 6.0 * math.cos(angle), 6.0 * math.sin(angle)


@pytest.mark.parametrize("heading", [1, -1])
@pytest.mark.parametrize(
    ("side", "action", "direction"),
    [(1, Action.PATROL_COUNTER_CLOCKWISE, -1), (-1, Action.PATROL_CLOCKWISE, 1)],
)
def test_meeting_a_teammate_reverses_the_direction_for_good(heading, side, action, direction):
    robot = patrol()
    robot.step(0.0, on_circle(0.0, heading=heading), None)
    met = robot.step(0.6, on_circle(0.0, heading=heading), at_distance(1.5, side))
    assert met.action is action
    assert met.velocity == pytest.approx((0.0, -0.35 * direction), abs=1e-9)
    after = robot.step(1.2, on_circle(0.0, heading=heading), at_distance(2.2, side))
    assert after.action is Action.KEEP_GOING
    assert after.direction == direction


def test_avoid_teammate_is_equation_12():
    """Away from the teammate at full escape speed, and to the border across that."""
    robot = patrol(LINE)
    decision = robot.step(0.0, Pose(10.0, 0.4, 0.0), (10.8, 0.4))
    assert decision.action is Action.AVOID_TEAMMATE
    assert decision.velocity == pytest.approx((-0.3, -0.12))
    assert decision.gamma == 1.0
    # the border is straight behind the teammate: nothing left for Reach Frontier
    robot = patrol(LINE)
    decision = robot.step(0.0, Pose(10.0, 1.8, 0.0), (10.0, 1.0))
    assert decision.velocity == pytest.approx((0.0, 0.3))


def test_avoid_teammate_without_one_reaches_the_border():
    foot = LINE.project(10.0, 1.0)
    situation = Situation(
        0.0,
        (10.0, 1.0),
        0.0,
        foot,
        None,
        NO_NEIGHBOR,
        (10.0, 10.0),
        None,
        None,
        False,
        foot.distance,
    )
    velocity = action_velocity(Action.AVOID_TEAMMATE, situation, 1, PatrolSettings())
    assert velocity == pytest.approx((0.0, -0.3))


def test_random_reversal_happens_only_during_keep_going():
    robot = patrol(reversal_probability=1.0, reversal_period=1.0)
    directions = [robot.step(0.1 * k, on_circle(0.0), None).direction for k in range(60)]
    assert 4 <= np.count_nonzero(np.diff(directions)) <= 6
    robot = patrol(reversal_probability=1.0, reversal_period=1.0)
    met = [robot.step(0.1 * k, on_circle(0.0), at_distance(1.5, -1)) for k in range(60)]
    assert {d.direction for d in met} == {1}
    assert TurnCause.CHANCE not in {d.turn for d in met}


def test_no_random_reversal_near_an_end():
    for x, expected in ((0.7, set()), (1.2, {TurnCause.CHANCE})):
        robot = patrol(LINE, reversal_probability=1.0, reversal_period=1.0)
        found = [robot.step(0.1 * k, Pose(x, 0.0, 0.0), None) for k in range(40)]
        assert {d.action for d in found} == {Action.KEEP_GOING}
        assert {d.turn for d in found} - {None} == expected


def test_every_turn_has_its_cause():
    robot = patrol()
    robot.step(0.0, on_circle(0.0), None)
    met = robot.step(0.6, on_circle(0.0), at_distance(1.5, 1))
    assert met.turn is TurnCause.TEAMMATE
    assert robot.step(0.7, on_circle(0.0), at_distance(1.5, 1)).turn is None
    at_end = patrol(LINE)
    at_end.step(0.0, Pose(1.0, 0.0, math.pi), None)
    assert at_end.step(1.0, Pose(0.3, 0.0, math.pi), None).turn is TurnCause.RULES


@pytest.mark.parametrize("seed", range(40))
def test_blockage_and_chance_in_one_step_turn_once(seed):
    """Regression: a blockage and a random reversal in the same step cancelled each other."""
    robot = patrol(reversal_probability=1.0, reversal_period=0.7, seed=seed)
    directions, turns = [], []
    for k in range(230):
        decision = robot.step(0.1 * k, on_circle(0.0), None, held=True)
        directions.append(decision.direction)
        turns.append(decision.turn)
    assert [a != b for a, b in pairwise(directions)] == [turn is not None for turn in turns[1:]]
    assert {TurnCause.CHANCE, TurnCause.BLOCKAGE} == set(turns) - {None}


def test_without_modifiers_every_action_is_the_raw_winner():
    """No hold at an end, no dwell, no timeouts: the arbiter's choice in every step."""
    robot = patrol(LINE, modifiers=())
    caught = [robot.step(0.1 * k, Pose(0.3, 0.0, math.pi), (1.7, 0.0)) for k in range(200)]
    assert {d.override for d in caught} == {None}
    assert not any(d.holding for d in caught)
    assert all(d.action is d.raw_winner for d in caught)
    turning = [robot.step(30.0, Pose(5.0, 0.0, 0.0), (6.5, 0.0))]
    turning.append(robot.step(30.1, Pose(5.0, 0.0, 0.0), None))
    assert [d.action for d in turning] == [Action.PATROL_COUNTER_CLOCKWISE, Action.KEEP_GOING]


@pytest.mark.parametrize("name", DEFAULT_MODIFIERS)
def test_every_modifier_can_be_switched_off(name):
    without = {name, "common_turns"} if name == "even_gaps" else {name}
    modifiers = tuple(each for each in DEFAULT_MODIFIERS if each not in without)
    decision = patrol(LINE, modifiers=modifiers).step(0.0, Pose(5.0, 0.0, 0.0), None)
    assert decision.action is Action.KEEP_GOING


def test_a_modifier_named_twice_is_refused():
    with pytest.raises(ValueError, match="twice"):
        PatrolSettings(modifiers=("dwell", "dwell"))


def test_turns_at_the_ends_of_an_open_border():
    left = patrol(LINE).step(0.0, Pose(0.3, 0.0, math.pi), None)
    assert (left.action, left.direction) == (Action.PATROL_CLOCKWISE, 1)
    assert left.velocity == pytest.approx((0.35, 0.0))
    right = patrol(LINE).step(0.0, Pose(19.8, 0.0, 0.0), None)
    assert (right.action, right.direction) == (Action.PATROL_COUNTER_CLOCKWISE, -1)
    assert right.distance_from_right_end == pytest.approx(0.2)
    assert right.distance_from_left_end == pytest.approx(19.8)


def test_closed_border_has_no_ends():
    decision = patrol().step(0.0, on_circle(0.0), None)
    assert decision.distance_from_left_end == decision.distance_from_right_end == math.inf


def test_beyond_an_end_comes_back_along_the_border_too():
    decision = patrol(LINE).step(0.0, Pose(-0.5, 0.2, 0.0), None)
    assert decision.action is Action.PATROL_CLOCKWISE
    assert decision.velocity == pytest.approx((0.35 + 0.15, -0.06), abs=0.01)


def test_tangential_velocity_is_cut_off_at_an_end():
    """Avoiding a teammate does not move the robot beyond the border's end."""
    robot = patrol(LINE, modifiers=("hold_at_end",))
    robot.step(0.0, Pose(1.0, 0.0, math.pi), None)
    decision = robot.step(0.1, Pose(0.0, 0.0, math.pi), (1.8, 0.0))
    assert decision.velocity == pytest.approx((0.0, 0.0))


def test_caught_between_end_and_teammate_holds():
    decision = patrol(LINE).step(0.0, Pose(0.3, 0.0, math.pi), (1.7, 0.0))
    assert decision.holding
    assert decision.velocity == (0.0, 0.0)
    free = patrol(LINE).step(0.0, Pose(2.0, 0.0, math.pi), (3.4, 0.0))
    assert not free.holding
    assert free.action is Action.PATROL_COUNTER_CLOCKWISE


@pytest.mark.parametrize(("x", "mate", "vx"), [(0.2, 1.6, 0.2), (19.8, 18.4, -0.2)])
def test_caught_by_a_standing_teammate_leaves_the_end_after_a_while(x, mate, vx):
    robot = patrol(LINE)
    steps = [robot.step(0.1 * k, Pose(x, 0.0, 0.0), (mate, 0.0)) for k in range(130)]
    assert all(step.holding for step in steps[10:119])
    assert steps[-1].velocity == pytest.approx((vx, 0.0))
    assert steps[-1].override is OverrideReason.STANDOFF
    assert not steps[-1].holding


def test_caught_with_a_teammate_too_near_avoids():
    decision = patrol(LINE).step(0.0, Pose(0.3, 0.0, math.pi), (0.9, 0.0))
    assert decision.action is Action.AVOID_TEAMMATE


def test_abscissa_does_not_jump_between_two_equally_near_stretches():
    """On the medial axis of a narrow border the projection does not jump to and fro."""
    strip = Border(
        [
            Segment((0.0, 0.0), (20.0, 0.0)),
            Arc((20.0, 0.75), 0.75, -math.pi / 2, math.pi),
            Segment((20.0, 1.5), (0.0, 1.5)),
            Arc((0.0, 0.75), 0.75, math.pi / 2, math.pi),
        ],
        closed=True,
    )
    robot = patrol(strip)
    rng = np.random.default_rng(3)
    abscissae = [
        robot.step(0.1 * k, Pose(8.0, 0.75 + rng.uniform(-0.009, 0.009), 0.0), None).abscissa
        for k in range(30)
    ]
    assert np.ptp(abscissae) < 0.1


def test_same_seed_and_inputs_give_the_same_decisions():
    robots = [patrol(reversal_probability=0.5, reversal_period=1.0, seed=4) for _ in range(2)]
    for k in range(50):
        one, other = (r.step(0.1 * k, on_circle(0.01 * k), None) for r in robots)
        assert one == other


def test_rules_file_setting_replaces_the_shipped_rules(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text("")
    with pytest.raises(RulesError, match=r"own\.toml: file: .* missing"):
        patrol(rules_file=str(path))


def test_settings_refuse_thresholds_out_of_order():
    with pytest.raises(ValueError, match="passing_distance"):
        PatrolSettings(patrolling_distance=2.5)
    with pytest.raises(ValueError, match="approach_speed"):
        PatrolSettings(patrol_speed=0.6)
    with pytest.raises(RulesError, match="safety_distance"):
        patrol(safety_distance=1.2)


def test_refuses_a_border_too_tight_to_follow():
    corner = Arc((4.0, 0.4), 0.4, -math.pi / 2, math.pi / 2)
    tight = Border(
        [Segment((0.0, 0.0), (4.0, 0.0)), corner, Segment((4.4, 0.4), (4.4, 4.0))], closed=False
    )
    with pytest.raises(BorderError, match=r"primitive 2 .* radius 0\.40 m, .* follow 0\.5 m"):
        patrol(tight)
    patrol(tight, turning_radius=0.4)
