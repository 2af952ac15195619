"""Robots with cameras in lockstep: classification, reports and recordings."""

from __future__ import annotations

import math
from contextlib import closing
from pathlib import Path

import pytest

from maps.map_folder import MapFolder, load_map_folder
from maps.pose import Pose
from robot_agent.config import AgentConfig, find_map
from robot_agent.messages.effects import Publish
from robot_agent.messages.events import BlobsSeen, LinkDown, PictureTaken
from robot_agent.messages.foxglove import SceneUpdate
from robot_agent.messages.streams import IntruderPayload, StatusPayload, decode
from robot_agent.perception.identity import Kind
from tools.bench.fleet import Fleet
from tools.bench.fleet_recorder import FleetRecorder
from tools.logs.recording import Recording, read_recording
from tools.replay.replay import Replay
from tools.simulation.robot_body import BodyKind
from tools.simulation.stranger import PERSON

DURATION = 8.0


@pytest.fixture(scope="module")
def folder() -> MapFolder:
    return load_map_folder(find_map("paper_lab", Path.cwd()))


def ahead_of(folder: MapFolder, s: float, ahead: float, aside: float, turned: float) -> Pose:
    """Return a pose ahead of the border's point s, aside of it to the left, m and rad."""
    assert folder.border is not None
    at = folder.border.at(s)
    here = Pose(at.x, at.y, math.atan2(at.ty, at.tx))
    return here.compose(Pose(ahead, aside, turned))


@pytest.fixture(scope="module")
def met(folder: MapFolder, tmp_path_factory: pytest.TempPathFactory) -> tuple[Fleet, Path]:
    """Run two robots that meet head on, with a person beside the first one's path; recorded."""
    target = tmp_path_factory.mktemp("met")
    starts = [ahead_of(folder, 32.0, 0.0, 0.0, 0.0), ahead_of(folder, 32.0, 5.0, 0.0, 3.14159)]
    with closing(FleetRecorder(folder, target)) as recorder:
        fleet = Fleet(folder, 2, 5, starts=starts, observer=recorder.observe, cameras=True)
        place = ahead_of(folder, 32.0, 2.4, 1.1, 0.3)
        person = fleet.world.add_body(place, PERSON)
        person.kind = BodyKind.PERSON
        while fleet.t < DURATION:
            fleet.step()
        fleet.shut_down()
    return fleet, target


def effects(recording: Recording, stream: str) -> list[bytes]:
    return [
        item.payload
        for item in recording.items()
        if isinstance(item, Publish) and item.stream == stream
    ]


def test_robot_with_a_band_is_classified_as_teammate(met: tuple[Fleet, Path]) -> None:
    agent = met[0].robots[0].agent
    mates = [track for track in agent.perception.tracker.tracks if track.teammate]
    assert len(mates) == 1
    assert mates[0].by_color


def test_person_is_reported_once_as_stranger_with_evidence(met: tuple[Fleet, Path]) -> None:
    fleet, target = met
    recording = read_recording(target / "robot1.mcap")
    said = [payload for payload in effects(recording, "event") if b'"intruder"' in payload]
    assert len(said) == 1
    told = [decode("intruder", payload) for payload in effects(recording, "intruder")]
    assert {each.number for each in told if isinstance(each, IntruderPayload)} == {1}
    first = told[0]
    assert isinstance(first, IntruderPayload)
    person = fleet.world.bodies[2].pose
    assert abs(first.x - person.x) + abs(first.y - person.y) < 0.3
    assert len(first.scan) >= 6
    assert any(isinstance(each, IntruderPayload) and each.picture for each in told)
    strangers = [
        track
        for track in fleet.robots[0].agent.perception.tracker.tracks
        if track.kind is Kind.STRANGER
    ]
    assert len(strangers) <= 1


def test_reported_stranger_is_shown_as_intruder(
    met: tuple[Fleet, Path],
) -> None:
    recording = read_recording(met[1] / "robot1.mcap")
    kinds = set()
    for payload in effects(recording, "tracks"):
        told = decode("tracks", payload)
        assert isinstance(told, SceneUpdate)
        for entity in told.entities:
            kinds |= {pair.value for pair in entity.metadata if pair.key == "kind"}
    assert "intruder" in kinds, "the word that the operator's alarm and page go by"
    assert kinds <= {"intruder", *Kind}


def test_recording_contains_bands_and_picture_and_replays_identically(
    met: tuple[Fleet, Path],
) -> None:
    recording = read_recording(met[1] / "robot1.mcap")
    kinds = {type(item) for item in recording.items()}
    assert {BlobsSeen, PictureTaken} <= kinds
    result = Replay(recording).run()
    assert result.difference is None
    assert result.decisions > 50


def test_unplugged_camera_is_in_the_status_and_patrol_goes_on(folder: MapFolder) -> None:
    starts = [ahead_of(folder, 32.0, 0.0, 0.0, 0.0)]
    fleet = Fleet(folder, 1, 5, AgentConfig(), starts, cameras=True)
    robot = fleet.robots[0]
    while fleet.t < 5.0:
        fleet.step()
    assert robot.agent.health_summary.degraded(fleet.t) == []
    robot.agent.handle(LinkDown(round(fleet.t, 6), "camera", "unplugged"))
    [words] = robot.agent.health_summary.degraded(fleet.t)
    assert "camera down (unplugged)" in words
    assert "outline and motion" in words


def test_dark_camera_is_reported_blind(folder: MapFolder) -> None:
    starts = [ahead_of(folder, 32.0, 0.0, 0.0, 0.0)]
    fleet = Fleet(folder, 1, 5, AgentConfig(), starts, cameras=True)
    agent = fleet.robots[0].agent
    while fleet.t < 5.0:
        fleet.step()
    for k in range(15):
        t = round(5.0 + 0.1 * k, 6)
        agent.handle(BlobsSeen(t, t, "dark", ()))
    status = agent.telemetry.on_time(7.0)[0][1]
    assert isinstance(status, StatusPayload)
    assert status.camera is not None
    assert status.camera.state in ("dark", "silent")
    assert any("camera" in words for words in status.degraded)
