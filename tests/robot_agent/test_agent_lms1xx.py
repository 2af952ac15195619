"""The agent with an LMS 111 in place of the LMS 200: 270 degrees, 50 scans a second."""

from __future__ import annotations

import math
from pathlib import Path

import msgspec
import numpy as np
import pytest

from drivers.lms1xx.session import SessionState
from drivers.lms1xx.settings import LaserSettings
from maps.map_folder import MapFolder, load_map_folder
from maps.pose import Pose
from robot_agent.agent import Agent
from robot_agent.config import AgentConfig, ConfigError, find_map, format_config, parse_config
from robot_agent.messages.events import BytesReceived
from robot_agent.motion.field_of_view import are_covered
from tests.robot_agent.tape import Tape
from tools.bench.fleet import Fleet
from tools.simulation.truth.truth import load_truth

START = Pose(8.0, 3.75, 0.0)  # in paper_lab's south corridor, heading along it
WITH_LMS_111 = AgentConfig(laser=LaserSettings())
BEHIND = (-0.6, -0.7)  # m in base_link: 130 degrees to the right of ahead


@pytest.fixture(scope="module")
def folder() -> MapFolder:
    return load_map_folder(find_map("paper_lab", Path()))


def run(
    folder: MapFolder, seconds: float, config: AgentConfig = WITH_LMS_111, truth: str = "lms1xx"
) -> tuple[Fleet, Tape]:
    tape = Tape()
    fleet = Fleet(
        *(folder, 1, 1, config, [START], lambda _name, _config: tape), truth=load_truth(truth)
    )
    while fleet.t < seconds:
        fleet.step()
    return fleet, tape


@pytest.fixture(scope="module")
def patrol(folder: MapFolder) -> tuple[Fleet, Tape]:
    return run(folder, 15.0)


def test_it_drives_and_knows_its_place(patrol: tuple[Fleet, Tape]) -> None:
    robot = patrol[0].robots[0]
    agent, true = robot.agent, robot.rig.body.pose
    assert agent.laser.state == SessionState.STREAMING
    assert robot.rig.base.velocity[0] > 0.3
    estimate = agent.pose_tracker.trusted_pose_at(patrol[0].t)
    assert estimate is not None
    assert math.hypot(estimate.x - true.x, estimate.y - true.y) < 0.05
    assert not patrol[0].world.contacts


def test_replay_is_live(patrol: tuple[Fleet, Tape], folder: MapFolder) -> None:
    fleet, tape = patrol
    agent = Agent(parse_config(format_config(fleet.robots[0].agent.config).encode(), "x"), folder)
    for event, effects in tape.steps:
        assert agent.handle(event) == effects


def test_every_scan_is_an_obstacle_and_one_a_decision_locates(
    patrol: tuple[Fleet, Tape], folder: MapFolder
) -> None:
    fleet, tape = patrol
    agent = Agent(fleet.robots[0].agent.config, folder)
    seen, located = set(), set()
    for event, _ in tape.steps:
        agent.handle(event)
        if isinstance(event, BytesReceived) and event.t > fleet.t - 5.0:
            seen.add(agent.scan_seen_at)
            if agent.localizer.estimate is not None:
                located.add(agent.localizer.estimate.t)
    assert len(seen) == pytest.approx(250, abs=3)
    assert len(located) == pytest.approx(50, abs=2)


def test_it_sees_behind_where_an_lms_200_does_not(
    patrol: tuple[Fleet, Tape], folder: MapFolder
) -> None:
    other, _ = run(folder, 5.0, AgentConfig(), "plain")
    views = [fleet.robots[0].agent.surroundings.views(fleet.t)[:1] for fleet in (patrol[0], other)]
    assert [are_covered([BEHIND], view) for view in views] == [True, False]
    assert views[0][0].half_angle == pytest.approx(math.radians(135.0))


def test_an_lms_200_configured_where_an_lms_111_is_stands(folder: MapFolder) -> None:
    fleet, _ = run(folder, 6.0, AgentConfig())
    assert fleet.robots[0].rig.body.pose == START


def test_it_stands_while_the_scanner_is_off_and_goes_on_after_it(folder: MapFolder) -> None:
    fleet = Fleet(folder, 1, 1, WITH_LMS_111, [START], truth=load_truth("lms1xx"))
    robot = fleet.robots[0]
    while fleet.t < 5.0:
        fleet.step()
    robot.rig.laser.power_off(fleet.t)
    while fleet.t < 8.0:
        fleet.step()
    assert robot.rig.base.velocity == (0.0, 0.0)
    robot.rig.laser.power_on(fleet.t)
    while fleet.t < 16.0:
        fleet.step()
    assert robot.agent.laser.state == SessionState.STREAMING
    assert robot.rig.base.velocity[0] > 0.1


def test_scan_age_and_period_are_the_scanners() -> None:
    slow = msgspec.structs.replace(LaserSettings(), frequency=25.0, resolution_deg=0.25)
    assert np.array([LaserSettings().scan_period, slow.scan_period]) == pytest.approx([0.02, 0.04])


def test_kind_is_lms200_where_it_is_not_said() -> None:
    config = parse_config(b"[laser]\nbaud = 9600\n", "x")
    assert config.laser.baud == 9600
    assert 'kind = "lms200"' in format_config(config)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b'[laser]\nkind = "lms300"', "laser.kind"),
        (b'[laser]\nkind = "lms1xx"\nbaud = 9600', "laser.baud: unknown key"),
        (b"[laser]\nfrequency = 50.0", "laser.frequency: unknown key"),
        (b'[laser]\nkind = "lms1xx"\nfrequency = 60.0', "frequency is one of 15, 25"),
        (b'[laser]\nkind = "lms1xx"\nresolution_deg = 2.0', "resolution_deg is one of"),
        (b'[laser]\nkind = "lms1xx"\nignore = [[-50.0, 0.0]]', "-45 to 225"),
    ],
)
def test_what_does_not_fit_the_kind_is_refused(content: bytes, words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        parse_config(content, "robot.toml")
