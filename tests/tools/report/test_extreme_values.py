"""A recording with anything in any field of any stream is reported, played and replayed."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from maps.input_limits import MAX_DURATION_S
from maps.pose import Pose
from robot_agent.messages.effects import Publish
from robot_agent.messages.events import BytesReceived, Shutdown, Tick
from robot_agent.messages.streams import STREAMS, encode
from robot_agent.recording.recording_writer import RecordingWriter
from tests.robot_agent.messages.extreme_payloads import extreme_payloads
from tests.tools.monitor.agent_recordings import header_of
from tests.tools.monitor.reports import decision, pose, status
from tools.cli import main
from tools.logs.recording import read_recording
from tools.monitor.page_message import PageFeed
from tools.monitor.playback import Playback
from tools.monitor.site import Site
from tools.monitor.team_state import TeamState
from tools.monitor.watch import Watch
from tools.report.run_log import read_run

START = 1_700_000_000.0
LARGEST = 20_000
"""Bytes of a payload in these recordings; larger ones only make the test slow."""


@pytest.fixture(scope="module", params=STREAMS)
def recording(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A robot's ordinary recording with every extreme payload of one stream in it."""
    path: Path = tmp_path_factory.mktemp("extreme") / "robot.mcap"
    hostile = [data for data in extreme_payloads(request.param) if len(data) < LARGEST]
    with path.open("wb") as file:
        writer = RecordingWriter(file, header_of("robot", START))
        for step in range(max(50, len(hostile))):
            t = 0.1 * step
            writer.write_event(Tick(t))
            if step < 50:
                writer.write_event(BytesReceived(t, "base", b"\xfa\xfb"))
                writer.write_effect(t, Publish("pose", encode(pose(START + t, 0.01 * step))))
                writer.write_effect(t, Publish("decision", encode(decision(START + t))))
                writer.write_effect(t, Publish("status", encode(status(START + t))))
                writer.write_reference(t, Pose(0.01 * step, 0.0, 0.0))
            if step < len(hostile):
                writer.write_effect(t, Publish(request.param, hostile[step]))
        writer.write_event(Shutdown(t))
        writer.finish()
    return path


def test_report_leaves_out_what_does_not_fit(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["report", str(recording), "-o", str(tmp_path)]) == 0
    (robot,) = json.loads((tmp_path / "report.json").read_text())["robots"]
    assert robot["decisions"] >= 50
    if robot["unreadable"]:
        assert "messages do not fit their stream" in capsys.readouterr().err


def test_playback_shows_the_rest(recording: Path) -> None:
    clock = iter(range(1000))
    playback = Playback([recording], clock=lambda: float(next(clock)))
    playback.speed = 100.0
    watch = Watch(TeamState(), Site(None))
    while not playback.paused:
        playback.advance(watch)
        assert json.loads(PageFeed(watch).message(playback.description()))["robots"]


def test_items_and_tables_of_it_are_read(recording: Path, tmp_path: Path) -> None:
    assert len(list(read_recording(recording).items())) > 50
    topics = {topic for topic, _, _ in read_recording(recording).messages(None)}
    for stream in topics & set(STREAMS):
        target = str(tmp_path / "table.csv")
        assert main(["convert", str(recording), "-o", target, "--stream", stream]) == 0


def test_replay_says_that_it_differs(recording: Path) -> None:
    assert main(["replay", str(recording), "--check"]) == 1


def test_report_of_a_clock_that_jumps_ends_before_the_jump(tmp_path: Path) -> None:
    path = tmp_path / "jump.mcap"
    with path.open("wb") as file:
        writer = RecordingWriter(file, header_of("robot", START))
        for t in (0.0, 1.0, 2.0, MAX_DURATION_S + 1.0):
            writer.write_event(Tick(t))
            writer.write_effect(t, Publish("decision", encode(decision(START + t))))
        writer.finish()
    log = read_run(path)
    assert (log.end, log.decision_t.tolist()) == (2.0, [0.0, 1.0, 2.0])
    assert log.truncated is not None
    assert "not up to 172801 s" in log.truncated
