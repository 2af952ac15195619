"""The agent takes the robot's geometry from the one model that the session has."""

from pathlib import Path

import msgspec
import pytest

from drivers.p2os.model import load_model
from drivers.p2os.robot_identity import RobotIdentity
from drivers.p2os.session import SessionState
from maps.map_folder import MapFolder, load_map_folder
from maps.pose import Pose
from robot_agent.agent import Agent
from robot_agent.config import AgentConfig, find_map
from robot_agent.motion.gate_reason import GateReason
from tests.robot_agent.tape import Tape
from tools.bench.fleet import Fleet
from tools.simulation.rig import outline_of
from tools.simulation.truth.truth import load_truth

START = Pose(5.0, 13.4, 0.3)


@pytest.fixture(scope="module")
def folder() -> MapFolder:
    return load_map_folder(find_map("paper_lab", Path()))


def run(
    folder: MapFolder,
    seconds: float,
    truth: str = "plain",
    subclass: str | None = None,
    model: str | None = None,
) -> tuple[Fleet, Tape]:
    """Run one robot; subclass: what its base says it is; model: as configured."""
    tape = Tape()
    config = msgspec.structs.replace(
        AgentConfig(), base=msgspec.structs.replace(AgentConfig().base, model=model)
    )
    fleet = Fleet(
        folder,
        1,
        seed=5,
        starts=[START],
        config=config,
        observer=lambda *_: tape,
        truth=load_truth(truth),
    )
    if subclass is not None:
        fleet.robots[0].rig.base.identity = RobotIdentity("R", "Pioneer", subclass)
    while fleet.t < seconds:
        fleet.step()
    return fleet, tape


def test_robot_without_bumpers_drives_and_says_that_it_has_none(folder: MapFolder) -> None:
    fleet, tape = run(folder, 12.0, "no_bumpers")
    assert START.between(fleet.robots[0].rig.body.pose).x > 1.0
    assert tape.logged("bumpers") == ["no bumpers fitted (every bit reads 1)"]


def test_robot_on_its_charger_stands(folder: MapFolder) -> None:
    fleet, _ = run(folder, 12.0, "charging")
    robot = fleet.robots[0]
    assert robot.rig.body.pose == START
    assert robot.agent.gate_decision is not None
    assert robot.agent.gate_decision.reason is GateReason.CHARGING


def test_robot_of_an_unknown_subclass_stands_and_says_how_to_add_it(folder: MapFolder) -> None:
    fleet, tape = run(folder, 12.0, "unknown_subclass")
    robot = fleet.robots[0]
    assert robot.rig.body.pose == START
    assert robot.agent.base.state is SessionState.OPENING
    assert robot.agent.gate_decision is not None
    assert robot.agent.gate_decision.reason is GateReason.BODY_UNKNOWN
    said = tape.logged("base")[-1]
    assert "'p9zz'" in said
    assert 'base.model = "./mine.toml"' in said


def test_robot_that_contradicts_its_configured_model_stands(folder: MapFolder) -> None:
    fleet, tape = run(folder, 12.0, subclass="p3at", model="p2dx")
    assert fleet.robots[0].rig.body.pose == START
    said = tape.logged("base")[-1]
    assert "'p2dx'" in said
    assert "'p3at'" in said


def test_geometry_is_that_of_the_reported_model_live_and_in_replay(folder: MapFolder) -> None:
    fleet, tape = run(folder, 8.0, subclass="p3at")
    robot = fleet.robots[0]
    assert robot.agent.base.model is load_model("p3at")
    agent = Agent(robot.agent.config, folder)
    for event, effects in tape.steps:
        assert agent.handle(event) == effects


def test_robot_whose_vendor_mounts_the_laser_upside_down_drives_with_nothing_configured(
    folder: MapFolder,
) -> None:
    fleet, tape = run(folder, 12.0, "patrolbot-sh")
    assert fleet.robots[0].rig.base.velocity[0] > 0.1
    assert not tape.logged("laser.mount")


def test_a_large_teammate_that_drives_ahead_in_a_corridor_is_no_repeated_scan(
    folder: MapFolder,
) -> None:
    truth = load_truth("p2at")
    fleet = Fleet(folder, 1, seed=1, starts=[Pose(3.95, 6.9, 1.57)], truth=truth)
    robot = fleet.robots[0]
    ahead = Pose(2.6, 0.0, 0.0)
    teammate = fleet.world.add_body(robot.rig.body.pose.compose(ahead), outline_of(truth.robot))
    while fleet.t < 11.0:
        fleet.step()
        fleet.world.place(teammate, robot.rig.body.pose.compose(ahead))
    assert robot.rig.body.pose.y > 8.2
    assert robot.agent.pose_tracker.travel.fault is None


def test_robot_that_is_too_large_for_any_way_to_the_border_says_so_and_stands(
    folder: MapFolder,
) -> None:
    tape = Tape()
    fleet = Fleet(folder, 1, seed=1, observer=lambda *_: tape, truth=load_truth("seekur"))
    robot = fleet.robots[0]
    start = robot.rig.body.pose
    while fleet.t < 6.0:
        fleet.step()
    assert robot.rig.body.pose == start
    assert robot.agent.health_summary.health() == "patrol: no way to the border"
    (said,) = tape.logged("border")
    assert said.startswith("no way to the border between the walls")


def test_agent_expects_its_teammates_housings_where_its_own_scanner_stands(
    folder: MapFolder,
) -> None:
    fleet, _ = run(folder, 0.1)
    agent = fleet.robots[0].agent
    # 2-DX: the scanner 0.017 m ahead of the axle, the middle of the body 0.0455 m behind it.
    assert agent.perception.tracker.housing_ahead == pytest.approx(0.0625)
