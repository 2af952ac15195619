"""The automaton: its transitions, hysteresis and dwell, and where it agrees with the rules."""

import math

import numpy as np
import pytest

from maps.border import Border
from maps.border_primitives import Segment
from maps.pose import Pose
from robot_agent.patrol.actions import Action
from robot_agent.patrol.automaton import Automaton
from robot_agent.patrol.patrol import Patrol
from robot_agent.patrol.rules import RULES_FILE, RulesError, load_rules
from robot_agent.patrol.settings import PatrolSettings
from robot_agent.patrol.supervisor import Supervisor

ATA, ARF, AKG, PCW, PCCW = (
    Action.AVOID_TEAMMATE,
    Action.REACH_FRONTIER,
    Action.KEEP_GOING,
    Action.PATROL_CLOCKWISE,
    Action.PATROL_COUNTER_CLOCKWISE,
)
ALONE = {
    "distance_from_border": 0.0,
    "distance_from_neighbor": math.inf,
    "neighbor_state": 0.0,
    "distance_from_left_end": math.inf,
    "distance_from_right_end": math.inf,
}


def situation(border=0.0, neighbor=math.inf, gamma=0.0, left=math.inf, right=math.inf):
    return dict(zip(ALONE, (border, neighbor, gamma, left, right), strict=True))


def automaton(dwell=0.5):
    return Automaton(dwell)


def first(**inputs):
    return automaton().choose(0.0, situation(**inputs))


@pytest.mark.parametrize(
    ("inputs", "action"),
    [
        ({}, AKG),
        ({"border": 3.0}, ARF),
        ({"border": 3.0, "neighbor": 1.5}, ATA),
        ({"border": 3.0, "neighbor": 0.5}, ATA),
        ({"neighbor": 0.5}, ATA),
        ({"neighbor": 1.5, "gamma": -1.0}, PCW),
        ({"neighbor": 1.5, "gamma": 1.0}, PCCW),
        ({"neighbor": 1.5}, AKG),
        ({"border": 1.0, "neighbor": 1.5, "gamma": 1.0}, ATA),
        ({"border": 1.0, "neighbor": 1.5}, AKG),
        ({"neighbor": 2.2, "gamma": -1.0}, AKG),
        ({"left": 0.2}, PCW),
        ({"right": 0.2}, PCCW),
        ({"left": 0.2, "neighbor": 0.5}, ATA),
        ({"left": 0.2, "border": 3.0}, ARF),
    ],
)
def test_inputs_select_the_state(inputs, action):
    choice = first(**inputs)
    assert choice.winner is choice.raw_winner is action
    assert choice.degrees == {a: float(a is action) for a in Action}
    assert choice.runner_up is not action


def test_end_and_teammate_activate_both_directions():
    choice = first(left=0.2, neighbor=1.5, gamma=1.0)
    assert choice.degrees[PCW] == choice.degrees[PCCW] == 1.0
    assert {choice.winner, choice.runner_up} == {PCW, PCCW}


@pytest.mark.parametrize(
    ("inside", "outside", "between", "states"),
    [
        ({"border": 1.4}, {"border": 1.6}, {"border": 1.5}, (AKG, ARF)),
        ({"neighbor": 1.0}, {"neighbor": 1.2}, {"neighbor": 1.1}, (ATA, AKG)),
        (
            {"neighbor": 1.8, "gamma": -1.0},
            {"neighbor": 2.0, "gamma": -1.0},
            {"neighbor": 1.9, "gamma": -1.0},
            (PCW, AKG),
        ),
        (
            {"neighbor": 1.5, "gamma": 0.45},
            {"neighbor": 1.5, "gamma": 0.3},
            {"neighbor": 1.5, "gamma": 0.375},
            (PCCW, AKG),
        ),
        ({"left": 0.45}, {"left": 0.65}, {"left": 0.55}, (PCW, AKG)),
    ],
)
def test_state_is_kept_within_the_hysteresis(inside, outside, between, states):
    for inputs, state in zip((inside, outside), states, strict=True):
        machine = automaton(dwell=0.0)
        assert machine.choose(0.0, situation(**inputs)).winner is state
        assert machine.choose(1.0, situation(**between)).winner is state
    machine = automaton(dwell=0.0)
    winners = [
        machine.choose(0.1 * k, situation(**x)).winner for k, x in enumerate((inside, outside))
    ]
    assert tuple(winners) == states


def test_dwell_delays_all_actions_but_avoid_teammate():
    machine = automaton()
    machine.choose(0.0, situation(border=3.0))
    early = machine.choose(0.4, ALONE)
    assert (early.winner, early.raw_winner) == (ARF, AKG)
    assert machine.choose(0.5, ALONE).winner is AKG
    assert machine.choose(0.6, situation(neighbor=0.5)).winner is ATA
    assert machine.choose(0.7, situation(neighbor=1.5, gamma=-1.0)).winner is ATA
    assert machine.choose(0.8, ALONE).winner is AKG  # the teammate is gone


def test_agrees_with_the_rules_away_from_the_thresholds():
    """Same inputs, no history: the automaton is the rule base with sharp edges."""
    rules = load_rules(RULES_FILE, reading="R2", safety_distance=2.4, open_border=True)
    rng = np.random.default_rng(5)
    edges = {0: (0.7, 1.5), 1: (1.1, 1.9), 2: (-0.375, 0.375), 3: (0.55,), 4: (0.55,)}
    agreed = asked = 0
    while asked < 2000:
        values = rng.uniform((0, 0, -1, 0, 0), (3, 3, 1, 5, 5))
        if any(abs(values[i] - e) < 0.15 for i, found in edges.items() for e in found):
            continue
        inputs = situation(*map(float, values))
        fuzzy = Supervisor(rules, 0.0).choose(0.0, inputs)
        sharp = automaton().choose(0.0, inputs)
        asked += 1
        agreed += sharp.winner is fuzzy.winner or sharp.degrees[fuzzy.winner] == 1.0
    assert agreed / asked > 0.9  # R2 reaches the border where the automaton keeps going


def test_same_inputs_give_the_same_choices():
    rng = np.random.default_rng(1)
    one, other = automaton(), automaton()
    for k in range(300):
        inputs = situation(*map(float, rng.uniform((0, 0, -1, 0, 0), (3, 3, 1, 5, 5))))
        assert one.choose(0.1 * k, inputs) == other.choose(0.1 * k, inputs)


def test_setting_supervisor_selects_the_automaton():
    line = Border([Segment((0.0, 0.0), (20.0, 0.0))], closed=False)
    settings = PatrolSettings(supervisor="automaton", reversal_probability=0.0)
    decision = Patrol(settings, line, np.random.default_rng(0)).step(
        0.0, Pose(10.0, 0.0, 0.0), (11.5, 0.0)
    )
    assert decision.action is PCCW
    assert set(decision.degrees.values()) == {0.0, 1.0}


def test_too_small_safety_distance_raises():
    line = Border([Segment((0.0, 0.0), (20.0, 0.0))], closed=False)
    settings = PatrolSettings(supervisor="automaton", safety_distance=1.9)
    with pytest.raises(RulesError, match=r"safety_distance 1\.9 m must be at least 1\.95"):
        Patrol(settings, line, np.random.default_rng(0))
