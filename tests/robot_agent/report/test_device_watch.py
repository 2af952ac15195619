"""What an agent tells of its devices' sessions, by the shipped emulators in lockstep."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest

from drivers.lms1xx.session import LaserCounters as Lms1xxCounters
from drivers.lms200.session import LaserCounters as Lms200Counters
from drivers.p2os.session import SessionCounters
from maps.map_folder import MapFolder, load_map_folder
from robot_agent.config import find_map
from robot_agent.messages.effects import Publish
from robot_agent.messages.events import Shutdown
from robot_agent.messages.streams import StatusPayload, decode
from robot_agent.report.device_watch import COUNTED, PROGRESS
from tests.robot_agent.tape import Tape
from tools.bench.bench_fault import parse_fault
from tools.bench.fleet import Fleet

TOLD_AS_TROUBLE = {
    *("silences", "controller_resets", "searches"),
    *("rate_searches", "refused_limits", "unknown_models"),
}


@pytest.fixture(scope="module")
def folder() -> MapFolder:
    return load_map_folder(find_map("paper_lab", Path()), "border")


class OneRobot:
    """One robot with the tape of what it does and says."""

    def __init__(self, folder: MapFolder, fault: str = "") -> None:
        self.tape = Tape()
        faults = [parse_fault(fault)] if fault else []
        self.fleet = Fleet(folder, 1, seed=5, observer=lambda *_: self.tape, faults=faults)
        self.agent = self.fleet.robots[0].agent
        self.rig = self.fleet.robots[0].rig

    def run_until(self, t: float) -> None:
        while self.fleet.t < t:
            self.fleet.step()

    def said(self, part: str = "") -> list[str]:
        return [
            f"{log.level}:{log.name}: {log.message}"
            for log in self.tape.logs()
            if log.name.startswith(part)
        ]

    def status(self) -> StatusPayload:
        payloads = [
            effect.payload
            for effect in self.tape.effects()
            if isinstance(effect, Publish) and effect.stream == "status"
        ]
        status = decode("status", payloads[-1])
        assert isinstance(status, StatusPayload)
        return status


@pytest.fixture
def robot(folder: MapFolder) -> OneRobot:
    return OneRobot(folder)


def test_sound_devices_are_told_of_once_with_name_and_rate(robot: OneRobot) -> None:
    robot.run_until(8.0)
    assert robot.said("base") == ["2:base: port open", "2:base: ready: p2dx robot1 at 9600 baud"]
    assert robot.said("laser")[0] == "2:laser: port open"
    streaming = [line for line in robot.said("laser") if "streaming: LMS200" in line]
    assert len(streaming) == 1
    assert "at 38400 baud" in streaming[0]
    assert robot.status().base.trouble == ""


def test_silent_laser_is_told_with_what_to_do_and_the_robot_is_not_called_blind_before(
    robot: OneRobot,
) -> None:
    robot.rig.laser.power_off(0.0)
    robot.run_until(2.0)
    assert robot.said("perception") == []
    robot.run_until(14.0)
    words = "no laser answers at 38400, 9600, 19200, 500000 baud: check its power and cable"
    assert f"4:laser: {words}" in robot.said()
    assert robot.status().laser.trouble == words
    assert robot.agent.health_summary.health() == f"laser: {words}"
    assert [line for line in robot.said("perception") if "laser blind" in line]


def test_silent_base_is_told_and_its_laser_is_not_called_blind(folder: MapFolder) -> None:
    robot = OneRobot(folder, "robot1:deaf@0")
    robot.run_until(14.0)
    assert any("robot switched on? cable?" in line for line in robot.said("base"))
    assert robot.said("perception") == []
    assert robot.said("trust") == []
    assert robot.agent.health_summary.health().startswith("base: no reply at 9600")


def test_dirty_window_is_told_with_its_remedy_and_when_it_is_clean_again(robot: OneRobot) -> None:
    robot.run_until(6.0)
    robot.rig.laser.polluted = True
    robot.run_until(8.0)
    assert any("wipe it with a soft cloth" in line for line in robot.said("laser.health"))
    assert "laser.health" in robot.agent.warnings
    robot.rig.laser.polluted = False
    robot.run_until(15.0)
    assert robot.said("laser.health")[-1] == "2:laser.health: ok"
    assert "laser.health" not in robot.agent.warnings


def test_an_agent_that_ends_tells_of_no_silence(robot: OneRobot) -> None:
    robot.run_until(8.0)
    robot.agent.handle(Shutdown(robot.fleet.t))
    before = len(robot.said())
    robot.run_until(10.0)
    assert robot.said()[before:] == []


@pytest.mark.parametrize(
    ("link", "sessions"),
    [("base", (SessionCounters,)), ("laser", (Lms200Counters, Lms1xxCounters))],
)
def test_every_counter_has_words_or_is_told_otherwise(link: str, sessions: tuple[Any, ...]) -> None:
    names = {each.name for session in sessions for each in fields(session)} | {"bad_checksum"}
    assert names - PROGRESS - TOLD_AS_TROUBLE == set(COUNTED[link])  # type: ignore[index]
