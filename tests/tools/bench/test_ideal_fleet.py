"""The ideal bench: the agent's decision layer on true poses."""

import math
from pathlib import Path

import msgspec
import numpy as np
import pytest

from maps.map_folder import MapFolder, load_map_folder
from maps.pose import Pose
from robot_agent.config import find_map, parse_config
from robot_agent.patrol.actions import Action
from robot_agent.patrol.patrol import Patrol
from robot_agent.patrol.settings import PatrolSettings
from tools.bench.bench_fault import BenchFault, BenchFaultError, FaultKind
from tools.bench.fleet import Fleet
from tools.bench.ideal_fleet import IdealFleet, run_ideal_bench
from tools.bench.sensing import Sensing, bench


@pytest.fixture(scope="module")
def folder() -> MapFolder:
    return load_map_folder(find_map("paper_lab", Path.cwd()))


@pytest.fixture(scope="module")
def intel() -> MapFolder:
    return load_map_folder(find_map("intel_lab", Path.cwd()))


def head_on(folder: MapFolder, gap: float) -> list[Pose]:
    """Return two robots on the border's northern side that face each other."""
    return [Pose(7.0, 13.75, 0.0), Pose(7.0 + gap, 13.75, math.pi)]


def keys(figures: object) -> object:
    """Return the keys of nested tables; of a list, of its first element."""
    if isinstance(figures, dict):
        return {key: keys(value) for key, value in figures.items()}
    return None


def test_figures_have_the_keys_of_the_byte_path(folder):
    byte_path = bench(Sensing.BYTES, folder, 1, 1, 1.0)
    ideal = bench(Sensing.IDEAL, folder, 1, 1, 1.0)
    assert keys(ideal) == keys(byte_path)
    assert (ideal["sensing"], byte_path["sensing"]) == ("ideal", "bytes")


def test_start_poses_equal_those_of_the_byte_path(folder):
    ideal, byte_path = IdealFleet(folder, 3, 5), Fleet(folder, 3, 5)
    assert [robot.body.pose for robot in ideal.robots] == [
        robot.rig.body.pose for robot in byte_path.robots
    ]


def test_same_seed_gives_the_same_run(folder):
    one, other = (run_ideal_bench(IdealFleet(folder, 5, 2), 60.0) for _ in range(2))
    assert one | {"wall_s": 0.0} == other | {"wall_s": 0.0}


def test_meeting_robots_turn_back_and_separate(folder):
    figures = run_ideal_bench(IdealFleet(folder, 2, 1, starts=head_on(folder, 5.0)), 14.0)
    (meeting,) = figures["meetings"]
    assert set(meeting["actions"]) == {Action.PATROL_CLOCKWISE, Action.PATROL_COUNTER_CLOCKWISE}
    assert meeting["outcome"] == "turned back"
    assert meeting["closest_m"] > 1.1
    assert figures["contacts"] == 0
    assert figures["action_share"][Action.AVOID_TEAMMATE] == 0.0


def test_three_robots_that_meet_at_one_place_all_separate(folder):
    starts = [Pose(7.0, 13.75, 0.0), Pose(9.4, 13.75, 0.0), Pose(12.0, 13.75, math.pi)]
    figures = run_ideal_bench(IdealFleet(folder, 3, 1, starts=starts), 40.0)
    assert len(figures["meetings"]) >= 2
    assert figures["contacts"] == 0
    assert figures["closest_m"] > 1.1
    assert figures["longest_avoid_s"] < 5.0


def test_robot_behind_a_slow_one_turns_back(folder):
    starts = [Pose(7.0, 13.75, 0.0), Pose(10.0, 13.75, 0.0)]
    fleet = IdealFleet(folder, 2, 1, starts=starts)
    slow = msgspec.structs.replace(PatrolSettings(), patrol_speed=0.1, reversal_probability=0.0)
    assert folder.border is not None
    fleet.robots[1].patrol = Patrol(slow, folder.border, np.random.default_rng(1))
    figures = run_ideal_bench(fleet, 20.0)
    (meeting,) = figures["meetings"]
    assert meeting["actions"] == [Action.PATROL_COUNTER_CLOCKWISE, Action.KEEP_GOING]
    assert figures["contacts"] == 0
    assert figures["closest_m"] > 1.1


def test_dead_robot_stands_and_teammates_turn_back(folder):
    fault = BenchFault("robot2", FaultKind.DEAD, 0.0)
    fleet = IdealFleet(folder, 2, 1, starts=head_on(folder, 5.0), faults=[fault])
    figures = run_ideal_bench(fleet, 20.0)
    assert fleet.robots[1].body.pose == Pose(12.0, 13.75, math.pi)
    assert [wreck[:2] for wreck in fleet.wrecks()] == [(12.0, 13.75)]
    assert fleet.robots[0].body.pose.x < 9.0
    assert figures["contacts"] == 0
    assert figures["faults"] == [{"robot": "robot2", "kind": "dead", "start": 0.0, "end": None}]


def test_device_faults_are_refused(folder):
    with pytest.raises(BenchFaultError, match=r"robot1 is one of devices.*use dead or stuck"):
        IdealFleet(folder, 1, 1, faults=[BenchFault("robot1", FaultKind.BLIND, 3.0)])


def test_even_gaps_bring_worst_idleness_near_the_minimum(folder):
    content = b"[patrol]\nreversal_probability = 0.0"
    figures = run_ideal_bench(IdealFleet(folder, 3, 1, parse_config(content, "test")), 2000.0)
    assert figures["settled"]["idleness_s"]["worst"] < 1.15 * 51.0 / (3 * 0.35)
    assert figures["contacts"] == 0


def test_gate_prevents_contacts_while_many_robots_reach_the_border(intel):
    figures = run_ideal_bench(IdealFleet(intel, 20, 1), 40.0)
    assert figures["contacts"] == 0
    assert figures["gate_stops"] > 0
    assert all(reached is not None for reached in figures["reach_s"][:10])


def test_no_robot_is_held_permanently_at_a_door_post(folder):
    """A robot whose turn is blocked by the gate turns the other way (regression: robot4 stuck)."""
    fleet = IdealFleet(folder, 8, 1)
    while fleet.t < 60.0:
        fleet.step()
    decision = fleet.robots[3].decision
    assert decision is not None
    assert decision.distance_from_border < 0.1
