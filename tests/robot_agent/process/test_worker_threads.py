"""Worker threads that end by an unexpected exception: it is reported, and nothing blocks."""

from __future__ import annotations

from pathlib import Path

import pytest

from drivers.camera import Camera
from drivers.camera_source import CameraSettings
from robot_agent.config import TelemetrySettings
from robot_agent.messages.events import Tick
from robot_agent.process.telemetry import Telemetry
from robot_agent.recording.recorder import Recorder
from robot_agent.recording.recording_writer import RecordingWriter
from robot_agent.recording.run_files import OneFile
from robot_agent.recording.run_header import RunHeader

pytestmark = pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")

HEADER = RunHeader(robot="r", team="t", seed=1, software_version="", start_wall_ns=0)


def die(*_: object) -> None:
    raise SystemExit


def test_dead_recorder_thread_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(RecordingWriter, "write_event", die)
    recorder = Recorder(OneFile(tmp_path / "run.mcap"), HEADER)
    recorder.record_event(Tick(0.0))
    recorder.close()
    assert "its thread has died" in recorder.failed
    recorder.record_event(Tick(0.1))
    assert recorder.lost == 1


def test_dead_telemetry_thread_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Telemetry, "_publish_all", die)
    telemetry = Telemetry(
        TelemetrySettings(operator="tcp/127.0.0.1:1"), robot="robot1", team="north"
    )
    telemetry.close()
    assert "its thread has died" in telemetry.failed
    assert telemetry.connected is None


def test_dead_camera_thread_is_not_alive(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Camera, "_open_and_grab", die)
    camera = Camera(CameraSettings(url="http://127.0.0.1:1/"))
    assert not camera.alive
    camera.start()
    camera.close()
    assert not camera.alive
