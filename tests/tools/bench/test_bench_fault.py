"""Faults of a bench run, through the real agents and every byte."""

import math
from pathlib import Path

import numpy as np
import pytest

from maps.map_folder import MapFolder, load_map_folder
from maps.pose import Pose
from robot_agent.config import find_map
from robot_agent.motion.gate_reason import GateReason
from tools.bench.bench_fault import (
    AWAY_M,
    BenchFault,
    BenchFaultError,
    FaultKind,
    draw_faults,
    parse_fault,
)
from tools.bench.fleet import Fleet, run_bench
from tools.metrics.border_visits import border_visits

SETTLED = 12.0


@pytest.fixture(scope="module")
def folder() -> MapFolder:
    return load_map_folder(find_map("paper_lab", Path.cwd()))


def one_robot(folder: MapFolder, kind: FaultKind, lasts: float = math.inf) -> Fleet:
    fault = BenchFault("robot1", kind, SETTLED + 0.005, SETTLED + lasts)
    fleet = Fleet(folder, 1, 3, starts=[Pose(5.0, 13.4, 0.0)], faults=[fault])
    run_until(fleet, SETTLED)
    assert fleet.robots[0].rig.base.velocity[0] > 0.2, "the robot must be on its way by then"
    return fleet


def run_until(fleet: Fleet, t: float) -> None:
    while fleet.t < t - 1e-9:
        fleet.step()


@pytest.mark.parametrize(
    ("kind", "within"),
    [
        (FaultKind.DEAD, 2.0 + 1.5),  # the base's watchdog, then its ramp
        (FaultKind.BLIND, 0.5 + 1.5),
        (FaultKind.DEAF, 0.6 + 1.5),
    ],
)
def test_robot_stands_while_the_fault_lasts_and_goes_on_after(
    folder: MapFolder, kind: FaultKind, within: float
) -> None:
    fleet = one_robot(folder, kind, lasts=6.0)
    rig = fleet.robots[0].rig
    run_until(fleet, SETTLED + within + 0.1)
    before = rig.body.pose
    run_until(fleet, SETTLED + 6.0)
    assert math.dist(before[:2], rig.body.pose[:2]) < 0.01
    run_until(fleet, SETTLED + 6.0 + 8.0)
    assert math.dist(before[:2], rig.body.pose[:2]) > 1.0
    assert fleet.world.contacts == 0


def test_robot_with_repeatedly_stuck_wheels_is_held_until_reset_by_a_person(
    folder: MapFolder,
) -> None:
    fleet = one_robot(folder, FaultKind.STUCK, lasts=6.0)
    robot = fleet.robots[0]
    before = robot.rig.body.pose
    run_until(fleet, SETTLED + 16.0)
    assert math.dist(before[:2], robot.rig.body.pose[:2]) < 0.01
    assert robot.agent.health_summary.health() == "gate: stalled_again"
    robot.rig.base.press_motors_button()
    run_until(fleet, SETTLED + 17.0)
    assert robot.rig.base.velocity == (0.0, 0.0)
    robot.rig.base.press_motors_button()
    run_until(fleet, SETTLED + 27.0)
    assert robot.rig.base.velocity[0] > 0.1
    assert fleet.world.contacts == 0


def test_stuck_wheels_are_a_stall_to_the_gate(folder: MapFolder) -> None:
    fleet = one_robot(folder, FaultKind.STUCK)
    reasons = set()
    while fleet.t < SETTLED + 1.0:
        fleet.step()
        gate = fleet.robots[0].agent.gate_decision
        reasons.add(gate.reason if gate else None)
    assert GateReason.STALLED in reasons
    (wreck,) = fleet.wrecks()
    assert wreck[:2] == fleet.robots[0].rig.body.pose[:2]
    assert (wreck.robot, wreck.since) == ("robot1", SETTLED + 0.005)


def test_carried_robot_returns_to_the_border(folder: MapFolder) -> None:
    fleet = one_robot(folder, FaultKind.CARRIED, lasts=1.0)
    assert folder.border is not None
    body = fleet.robots[0].rig.body
    run_until(fleet, SETTLED + 0.02)
    assert folder.border.project(body.pose.x, body.pose.y).distance > 0.3
    run_until(fleet, SETTLED + 30.0)
    assert folder.border.project(body.pose.x, body.pose.y).distance < 0.1
    assert fleet.world.contacts == 0


def test_robot_moved_elsewhere_is_lost_and_relocalizes(folder: MapFolder) -> None:
    fleet = one_robot(folder, FaultKind.AWAY, lasts=1.0)
    body, agent = fleet.robots[0].rig.body, fleet.robots[0].agent
    before = body.pose
    run_until(fleet, SETTLED + 0.02)
    assert math.dist(before[:2], body.pose[:2]) > AWAY_M
    run_until(fleet, SETTLED + 60.0)
    estimate = agent.localizer.estimate
    assert estimate is not None
    assert math.dist(estimate.pose[:2], body.pose[:2]) < 0.5
    assert fleet.world.contacts == 0


def test_dead_robot_is_listed_as_permanent_fault_and_not_hit(folder: MapFolder) -> None:
    faults = [parse_fault("robot1:dead@20")]
    figures = run_bench(Fleet(folder, 1, 3, faults=faults), 60.0)
    assert figures["faults"] == [{"robot": "robot1", "kind": "dead", "start": 20.0, "end": None}]
    assert figures["contacts"] == 0


def test_the_border_beside_a_wreck_is_left_out(folder: MapFolder) -> None:
    border = folder.border
    assert border is not None
    t = np.arange(10) * 0.1
    place = border.at(5.0)
    standing = np.tile((place.x, place.y), (10, 1))
    every = border_visits(border, [standing], t)
    marked = border_visits(border, [standing], t, [(place.x, place.y)])
    assert max(len(visited.arrivals) for visited in every.places) == 1
    assert max(len(visited.arrivals) for visited in marked.places) == 0
    assert 12 <= len(every.places) - len(marked.places) <= 20  # 4 m in steps of 0.25 m


@pytest.mark.parametrize(
    "text", ["", "robot1", "robot1:dead", "robot1:sleepy@3", "robot1:dead@x", "robot1:dead@5-5"]
)
def test_invalid_faults_are_refused(text: str) -> None:
    with pytest.raises(BenchFaultError, match="write ROBOT:KIND@START"):
        parse_fault(text)


def test_robots_and_times_are_drawn_from_the_seed() -> None:
    team = [f"robot{number}" for number in range(1, 21)]
    texts = ["any5:dead@100..400", "any1:blind@10+5"]
    drawn = draw_faults(texts, team, seed=1)
    assert drawn == draw_faults(texts, team, seed=1)
    assert drawn != draw_faults(texts, team, seed=2)
    assert len({fault.robot for fault in drawn}) == 6
    assert len({fault.start for fault in drawn[:5]}) == 5
    assert all(100.0 <= fault.start <= 400.0 and fault.is_permanent for fault in drawn[:5])
    assert (drawn[5].start, drawn[5].end) == (10.0, 15.0)
    with pytest.raises(BenchFaultError, match="not so many robots"):
        draw_faults(["any3:dead@1"], team[:2], seed=1)


def test_faults_are_parsed() -> None:
    assert parse_fault("robot2:blind@60-90.5") == BenchFault("robot2", FaultKind.BLIND, 60.0, 90.5)
    assert parse_fault("robot2:dead@60").is_permanent
    assert not parse_fault("robot2:dead@60-70").is_permanent


def test_fault_of_an_unknown_robot_is_refused(folder: MapFolder) -> None:
    with pytest.raises(BenchFaultError, match="fault of robot7: there is no such robot"):
        Fleet(folder, 1, 1, faults=[parse_fault("robot7:dead@1")])
