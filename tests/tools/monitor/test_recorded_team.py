"""Recording and playback: payloads unchanged, through a full disk and a killed monitor."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from contextlib import closing
from pathlib import Path
from threading import Thread

import pytest
from mcap.reader import make_reader

from maps.input_limits import MAX_PAYLOAD_BYTES, MAX_RECORDER_QUEUE_BYTES
from robot_agent.config import TelemetrySettings
from robot_agent.messages.streams import encode
from robot_agent.process.telemetry import Telemetry
from robot_agent.recording.recording_writer import CHUNK_BYTES
from tests.tools.monitor.agent_recordings import FOLDER, START, agent_recording
from tests.tools.monitor.reports import decision, pose
from tools.deploy.child_program import environment, program
from tools.logs.recording import RecordingError
from tools.monitor.endpoint import free_endpoint
from tools.monitor.monitor import Monitor, MonitorOptions
from tools.monitor.playback import Playback
from tools.monitor.recorded_payloads import RecordedPayloads
from tools.monitor.site import Site
from tools.monitor.source import Source
from tools.monitor.team_recorder import TeamRecorder
from tools.monitor.team_state import TeamState
from tools.monitor.watch import Watch

KEY = "patrol/north/anna"


def test_every_payload_is_recorded_unchanged(tmp_path: Path) -> None:
    path = tmp_path / "team.mcap"
    recorder = TeamRecorder(path, FOLDER, "border")
    heard = [
        (f"{KEY}/pose", encode(pose(1.0)), START),
        (f"{KEY}/pose", b"\xff not JSON", START + 0.1),
        ("patrol/north/bob/nonsense", b"", START + 0.2),
    ]
    for key, payload, wall in heard:
        recorder.on_payload(key, payload, wall)
    recorder.close()
    file = RecordedPayloads(path)
    kept = [(payload.key, payload.data, payload.t) for payload in file.payloads(0.0)]
    assert [item[:2] for item in kept] == [item[:2] for item in heard]
    assert [item[2] for item in kept] == pytest.approx([item[2] for item in heard])
    assert file.map_files == FOLDER.files
    with path.open("rb") as opened:  # as a stock reader sees it
        found = list(make_reader(opened).iter_messages())
    assert found[0][0].name == "foxglove.PoseInFrame"
    assert found[0][1].topic == f"{KEY}/pose"


def test_queue_of_a_slow_disk_is_bounded_in_bytes(tmp_path: Path) -> None:
    fifo = tmp_path / "slow.mcap"
    os.mkfifo(fifo)  # opening it waits for a reader: a disk that never gets to write
    recorder = TeamRecorder(fifo, None, "border")
    payload = b"1" * MAX_PAYLOAD_BYTES
    fitting = MAX_RECORDER_QUEUE_BYTES // MAX_PAYLOAD_BYTES
    for _ in range(fitting + 7):
        recorder.on_payload("patrol/north/anna/scan", payload, 1.0)
    assert recorder.lost == 7
    with fifo.open("rb") as reader:
        draining = Thread(target=reader.read, daemon=True)
        draining.start()
        recorder.close()
        draining.join()


def test_disk_full_is_an_alarm_and_the_monitor_goes_on() -> None:
    full = Path("/dev/full")
    if not full.exists():
        pytest.skip("no /dev/full here to play the full disk")
    options = MonitorOptions(free_endpoint(), None, Site(FOLDER), record=full)
    with closing(Monitor(options)) as monitor:
        deadline = time.monotonic() + 15.0
        while not monitor.watch.alarms.alarms():
            assert time.monotonic() < deadline, "no alarm"
            time.sleep(0.02)
        (alarm,) = monitor.watch.alarms.alarms()
        assert alarm.kind == "recording"
        assert alarm.text == "/dev/full: recording stopped: No space left on device"


def test_killed_monitor_leaves_a_readable_file(tmp_path: Path) -> None:
    path, endpoint = tmp_path / "team.mcap", free_endpoint()
    command = program("tools.cli", "monitor", "--text", "--listen", endpoint)
    with subprocess.Popen(
        [*command, "--record", str(path)], env=environment(), stdout=subprocess.DEVNULL
    ) as process:
        robot = Telemetry(TelemetrySettings(operator=endpoint), robot="anna", team="north")
        try:
            deadline = time.monotonic() + 40.0
            while not (path.exists() and path.stat().st_size > 1.2 * CHUNK_BYTES):  # one is whole
                assert time.monotonic() < deadline, "nothing was recorded"
                robot.publish("decision", encode(decision(1.0)) + b" " * 2000)
                robot.publish("pose", os.urandom(3000))  # does not compress: the file grows
                time.sleep(0.01)
        finally:
            robot.close()
            process.send_signal(signal.SIGKILL)
    payloads = list(RecordedPayloads(path).payloads(0.0))
    assert len(payloads) > 5
    assert {payload.key for payload in payloads} == {f"{KEY}/decision", f"{KEY}/pose"}


class Clock:
    """A clock that the test sets."""

    def __init__(self) -> None:
        self.t = 0.0

    def __call__(self) -> float:
        return self.t


@pytest.fixture
def played(tmp_path: Path) -> tuple[Playback, Watch, Clock]:
    """Two robots' files, the second of which begins 5 s later."""
    paths = [
        agent_recording("anna", tmp_path / "anna.mcap", START, 60.0),
        agent_recording("bob", tmp_path / "bob.mcap", START + 5.0, 60.0),
    ]
    clock = Clock()
    playback = Playback(paths, clock)
    site = playback.site()
    assert site.folder is not None
    assert site.folder.name == "paper_lab"
    return playback, Watch(TeamState(), site), clock


def run(source: Source, watch: Watch, clock: Clock, seconds: float) -> None:
    for _ in range(round(seconds / 0.05)):
        clock.t += 0.05
        source.advance(watch)


def places(watch: Watch) -> dict[str, float]:
    return {robot.robot: robot.poses[-1][1].x for robot in watch.robots}


def test_files_play_in_step_by_their_time_stamps(played: tuple[Playback, Watch, Clock]) -> None:
    playback, watch, clock = played
    assert (playback.start, playback.end) == pytest.approx((START, START + 64.9))
    run(playback, watch, clock, 4.0)
    assert set(places(watch)) == {"anna"}
    run(playback, watch, clock, 4.0)
    assert playback.t == pytest.approx(START + 8.0)
    assert places(watch) == pytest.approx({"anna": 0.8, "bob": 0.8}, abs=0.02)


def test_pause_speed_and_seek(played: tuple[Playback, Watch, Clock]) -> None:
    playback, watch, clock = played
    playback.steer(pause=None, speed=10.0, seek=None)
    run(playback, watch, clock, 2.0)
    assert playback.t == pytest.approx(START + 20.0)
    playback.steer(pause=True, speed=None, seek=None)
    run(playback, watch, clock, 2.0)
    assert playback.t == pytest.approx(START + 20.0)
    playback.steer(pause=None, speed=None, seek=START + 40.0)
    epoch = playback.epoch
    run(playback, watch, clock, 0.05)
    assert playback.epoch == epoch + 1
    assert playback.t == pytest.approx(START + 40.0)
    assert places(watch) == pytest.approx({"anna": 4.0, "bob": 4.0}, abs=0.12)
    assert watch.histories["north/anna"].count > 30, "what came before is there for the plots"
    playback.steer(pause=False, speed=None, seek=START - 1e9)
    run(playback, watch, clock, 0.1)
    assert playback.t == pytest.approx(START, abs=1.0)


def test_playback_pauses_at_the_end_and_resumes_from_the_start(
    played: tuple[Playback, Watch, Clock],
) -> None:
    playback, watch, clock = played
    playback.steer(pause=None, speed=100.0, seek=None)
    run(playback, watch, clock, 2.0)
    assert playback.paused
    assert playback.t == playback.end
    playback.steer(pause=False, speed=None, seek=None)
    run(playback, watch, clock, 0.05)
    assert playback.t == playback.start


def test_truncated_file_plays_up_to_the_cut(tmp_path: Path) -> None:
    path = agent_recording("anna", tmp_path / "anna.mcap", START, 60.0)
    file = RecordedPayloads(path)
    whole = len(list(file.payloads(0.0)))
    inside_the_seventh_chunk = file._index.chunks[6][0] + 40
    path.write_bytes(path.read_bytes()[:inside_the_seventh_chunk])
    assert len(list(RecordedPayloads(path).payloads(0.0))) == whole // 2


def test_file_without_telemetry_is_one_error(tmp_path: Path) -> None:
    for content, reason in ((b"hello", "is not an MCAP file"), (b"\x89MCAP0\r\n", "no telemetry")):
        path = tmp_path / "file.mcap"
        path.write_bytes(content)
        with pytest.raises(RecordingError, match=reason):
            RecordedPayloads(path)
    with pytest.raises(RecordingError, match="cannot be read"):
        RecordedPayloads(tmp_path / "absent.mcap")
