"""The arbiter: largest degree, ties, minimum dwell."""

import math

import pytest

from robot_agent.patrol.actions import Action
from robot_agent.patrol.fuzzy import MamdaniSystem, Rule, Trapezoid, Variable
from robot_agent.patrol.rules import RULES_FILE, load_rules
from robot_agent.patrol.supervisor import Supervisor

ALONE = {"distance_from_border": 0.0, "distance_from_neighbor": math.inf, "neighbor_state": 0.0}
FAR_OFF = ALONE | {"distance_from_border": 3.0}
MEETING = ALONE | {"distance_from_neighbor": 1.5, "neighbor_state": -1.0}
TOO_NEAR = ALONE | {"distance_from_neighbor": 0.5, "neighbor_state": -1.0}


def supervisor():
    rules = load_rules(RULES_FILE, reading="R1", safety_distance=2.4, open_border=False)
    return Supervisor(rules, 0.5)


def tied(*actions: Action) -> MamdaniSystem:
    """A system with equal degrees of some actions for any inputs."""
    sets = {"all": Trapezoid(-math.inf, -math.inf, math.inf, math.inf)}
    level = {"low": Trapezoid(0.0, 0.0, 0.0, 0.5), "high": Trapezoid(0.5, 1.0, 1.0, 1.0)}
    then = tuple((a.value, "high" if a in actions else "low") for a in Action)
    names = ("distance_from_border", "distance_from_neighbor", "neighbor_state")
    return MamdaniSystem(
        [Variable(name, sets) for name in names],
        [Variable(action.value, level) for action in Action],
        [Rule((("neighbor_state", "all"),), then)],
    )


def test_winner_has_the_largest_degree_and_runner_up_the_next():
    choice = supervisor().choose(0.0, ALONE | {"distance_from_border": 1.4})
    assert choice.winner is choice.raw_winner is Action.KEEP_GOING
    assert choice.runner_up is Action.REACH_FRONTIER
    assert choice.degrees[choice.winner] == max(choice.degrees.values())
    assert set(choice.degrees) == set(Action)


def test_minimum_dwell_keeps_the_winner_and_shows_the_raw_one():
    arbiter = supervisor()
    arbiter.choose(0.0, FAR_OFF)
    early = arbiter.choose(0.4, ALONE)
    assert (early.winner, early.raw_winner) == (Action.REACH_FRONTIER, Action.KEEP_GOING)
    assert arbiter.choose(0.5, ALONE).winner is Action.KEEP_GOING
    # the dwell counts from the change, not from the start
    assert arbiter.choose(0.9, FAR_OFF).winner is Action.KEEP_GOING
    assert arbiter.choose(1.0, FAR_OFF).winner is Action.REACH_FRONTIER


def test_dwell_at_ten_hertz_is_five_steps():
    arbiter = supervisor()
    arbiter.choose(0.0, FAR_OFF)
    t, steps = 0.0, 0
    while True:
        t, steps = t + 0.1, steps + 1
        if arbiter.choose(t, ALONE).winner is Action.KEEP_GOING:
            break
    assert steps == 5


def test_avoid_teammate_starts_within_the_dwell():
    arbiter = supervisor()
    arbiter.choose(0.0, ALONE)
    assert arbiter.choose(0.1, TOO_NEAR).winner is Action.AVOID_TEAMMATE
    assert arbiter.choose(0.2, MEETING).winner is Action.AVOID_TEAMMATE
    assert arbiter.choose(0.6, MEETING).winner is Action.PATROL_CLOCKWISE


def test_avoid_teammate_ends_at_once_without_a_teammate():
    arbiter = supervisor()
    arbiter.choose(0.0, TOO_NEAR)
    assert arbiter.choose(0.1, ALONE).winner is Action.KEEP_GOING


ATA, ARF, AKG, PCW, PCCW = (
    Action.AVOID_TEAMMATE,
    Action.REACH_FRONTIER,
    Action.KEEP_GOING,
    Action.PATROL_CLOCKWISE,
    Action.PATROL_COUNTER_CLOCKWISE,
)


@pytest.mark.parametrize(
    ("actions", "gamma", "order"),
    [
        ((AKG, ATA), 0.0, (ATA, AKG)),
        ((AKG, ARF), 0.0, (ARF, AKG)),
        ((ARF, ATA), 0.0, (ATA, ARF)),
        ((AKG, PCW), -1.0, (PCW, AKG)),
        ((PCW, PCCW), -1.0, (PCW, PCCW)),
        ((PCW, PCCW), 1.0, (PCCW, PCW)),
    ],
)
def test_tie_selects_the_safest_action(actions, gamma, order):
    choice = Supervisor(tied(*actions), 0.5).choose(0.0, ALONE | {"neighbor_state": gamma})
    assert (choice.raw_winner, choice.runner_up) == order


def test_tie_keeps_the_present_action():
    arbiter = supervisor()
    arbiter.choose(0.0, ALONE)
    boundary = ALONE | {"distance_from_border": 1.5}  # Keep Going and Reach Frontier are equal
    assert arbiter.choose(9.0, boundary).winner is Action.KEEP_GOING
    other = supervisor()
    other.choose(0.0, FAR_OFF)
    assert other.choose(9.0, boundary).winner is Action.REACH_FRONTIER
