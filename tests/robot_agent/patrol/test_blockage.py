"""The modifier blockage: wait before an object that is no teammate, then turn back and report."""

import math
from pathlib import Path

import numpy as np
import pytest

from maps.map_folder import load_map_folder
from maps.pose import Pose
from robot_agent.config import AgentConfig
from robot_agent.patrol.actions import Action
from robot_agent.patrol.blockage import Blockage
from robot_agent.patrol.neighbor_state import NeighborView
from robot_agent.patrol.patrol import Patrol
from robot_agent.patrol.settings import PatrolSettings
from robot_agent.patrol.turn_log import TurnCause
from tests.robot_agent.patrol.event_log import EventLog
from tests.robot_agent.patrol.situations import choice, situation
from tools.bench.fleet import Fleet
from tools.simulation.robot_body import Outline

LAB = load_map_folder(Path(__file__).parents[3] / "maps" / "paper_lab")
HERE = (0.0, 0.0)


def when(held, places=None, neighbors=None, duration=40.0):
    """Times of the turns; each argument is a function of t."""
    watch = Blockage()
    found = []
    for k in range(round(duration / 0.1)):
        t = round(0.1 * k, 1)
        place = places(t) if places else HERE
        neighbor = NeighborView(neighbors(t) if neighbors else math.inf, 0.0)
        now = situation(t, place, neighbor=neighbor, held=held(t))
        override = watch.propose(now, choice(Action.KEEP_GOING), Action.KEEP_GOING)
        if override is not None:
            assert override.turn is TurnCause.BLOCKAGE
            found.append(t)
    return found


def test_turns_after_ten_seconds_held_and_counts_again():
    assert when(lambda t: t >= 1.0, duration=33.0) == [11.0, 21.1, 31.2]


def test_without_an_obstacle_never_turns():
    assert when(lambda t: False) == []


def test_count_survives_flicker_but_not_a_pause():
    assert when(lambda t: round(10 * t) % 8 == 0, duration=12.0) == [10.4]
    assert when(lambda t: not 5.0 < t < 6.5, duration=16.4) == []
    assert when(lambda t: not 5.0 < t < 6.5, duration=17.0) == [16.5]


def test_moving_restarts_the_count():
    assert when(lambda t: True, places=lambda t: (0.02 * t, 0.0), duration=40.0) == []
    assert when(lambda t: True, places=lambda t: (0.2 if t >= 5 else 0, 0.0), duration=16.0) == [
        15.0
    ]


def test_with_a_teammate_near_does_not_turn():
    assert when(lambda t: True, neighbors=lambda t: 0.9) == []
    assert when(lambda t: True, neighbors=lambda t: 0.9 if t < 8 else 1.1, duration=19.0) == [18.0]


@pytest.mark.parametrize("heading", [0.0, math.pi])
def test_blockage_reverses_keep_going(heading):
    patrol = Patrol(PatrolSettings(reversal_probability=0.0), LAB.border, np.random.default_rng(0))
    found = [patrol.step(0.1 * k, Pose(8.0, 13.75, heading), None, held=True) for k in range(102)]
    assert [d.blocked for d in found].index(True) == 100
    before, after = found[99].direction, found[100].direction
    assert after == -before
    assert found[100].velocity[0] == pytest.approx(-found[99].velocity[0])
    assert found[101].direction == after


def test_box_on_the_border_is_waited_for_and_reported():
    """Slows, stops short of it, waits ten seconds, turns round and patrols the other way."""
    log = EventLog()
    config = AgentConfig(patrol=PatrolSettings(reversal_probability=0.0))
    starts = [Pose(5.5, 13.4, 0.0)]
    fleet = Fleet(LAB, 1, 1, config, starts, lambda name, config: log)
    box = fleet.world.add_body(Pose(9.0, 13.75, 0.0), Outline(0.1, 0.1, 0.15))
    (robot,) = fleet.robots
    rows = []
    while fleet.t < 32.0:
        fleet.step()
        decision, gate = robot.agent.decision, robot.agent.gate_decision
        if decision is not None:
            rows.append((fleet.t, robot.rig.body.pose.x, gate.v, decision.direction))
    t, x, v, direction = np.array(rows).T
    assert fleet.world.contacts == 0
    assert x.max() + 0.21 < box.pose.x - 0.1 - 0.1
    # 1. It slows down before it stops.
    stop = t[np.flatnonzero((v == 0.0) & (x > 8.0))[0]]
    assert ((v > 0.05) & (v < 0.25) & (t > stop - 2.0) & (t < stop)).any()
    # 2. It stands for ten seconds, then turns back, once.
    turned = t[np.flatnonzero(np.diff(direction))]
    assert len(turned) == 1
    assert 9.0 < turned[0] - stop < 11.5
    assert np.ptp(x[(t > stop + 1.0) & (t < turned[0])]) < 0.05
    # 3. It is on its way back and has reported the object.
    assert x[-1] < x.max() - 0.8
    assert robot.agent.decision.action is Action.KEEP_GOING
    said = [line for _, line in log.lines if "unknown object near s = 3." in line]
    assert len(said) == 1
    assert "turns back" in said[0]
