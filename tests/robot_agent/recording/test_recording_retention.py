from __future__ import annotations

import os
from pathlib import Path

import msgspec
import pytest

from robot_agent.config import RecorderSettings
from robot_agent.messages.events import Tick
from robot_agent.recording.recorder import Recorder
from robot_agent.recording.recording_retention import RecordingRetention
from robot_agent.recording.run_header import RunHeader
from tools.logs.recording import read_recording

HEADER = RunHeader(robot="r", team="t", seed=1, software_version="", start_wall_ns=0)


def make_run(folder: Path, number: int, size: int) -> Path:
    path = folder / f"r-{number}.mcap"
    path.write_bytes(bytes(size))
    os.utime(path, (number, number))
    return path


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_oldest_runs_are_deleted(tmp_path: Path) -> None:
    for number in (1, 2, 3):
        make_run(tmp_path, number, 400_000)
    current = make_run(tmp_path, 9, 400_000)
    (tmp_path / "other.mcap").write_bytes(bytes(9_000_000))
    room = RecordingRetention(current, RecorderSettings(keep_mb=1.0, leave_free_mb=0.0), "r-*.mcap")
    assert room.free_space() == ""
    assert names(tmp_path) == ["other.mcap", "r-3.mcap", "r-9.mcap"]


def test_run_too_large_alone_returns_the_reason(tmp_path: Path) -> None:
    make_run(tmp_path, 1, 10)
    current = make_run(tmp_path, 9, 1_000_001)
    room = RecordingRetention(current, RecorderSettings(keep_mb=1.0, leave_free_mb=0.0), "r-*.mcap")
    assert "keep_mb = 1" in room.free_space()
    assert names(tmp_path) == ["r-9.mcap"]


def test_without_a_pattern_nothing_is_deleted(tmp_path: Path) -> None:
    make_run(tmp_path, 1, 2_000_000)
    current = make_run(tmp_path, 9, 10)
    assert (
        RecordingRetention(current, RecorderSettings(keep_mb=1.0, leave_free_mb=0.0)).free_space()
        == ""
    )
    assert names(tmp_path) == ["r-1.mcap", "r-9.mcap"]


def test_nearly_full_disk_ends_the_recording_orderly(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    room = RecordingRetention(path, RecorderSettings(leave_free_mb=1e12))
    recorder = Recorder(path, HEADER, drain_period=0.001, flush_period=0.02, room=room)
    recorder.record_event(Tick(0.0))
    while not recorder.failed:
        pass
    recorder.record_event(Tick(1.0))
    recorder.close()
    assert "MB left" in recorder.failed
    assert recorder.lost == 1
    recording = read_recording(path)
    assert list(recording.items()) == [Tick(0.0)]
    assert recording.truncated is None


@pytest.mark.parametrize("settings", [{"keep_mb": 0.0}, {"leave_free_mb": -1.0}])
def test_invalid_limits_raise(settings: dict[str, float]) -> None:
    with pytest.raises(msgspec.ValidationError):
        msgspec.convert(settings, RecorderSettings)
