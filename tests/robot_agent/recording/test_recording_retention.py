from __future__ import annotations

import os
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import msgspec
import pytest

from robot_agent.config import RecorderSettings
from robot_agent.messages.events import Tick
from robot_agent.recording.recorder import Recorder
from robot_agent.recording.recording_retention import MEGABYTE, RecordingRetention
from robot_agent.recording.recording_writer import Gap
from robot_agent.recording.run_files import NumberedRuns, OneFile, RunFiles
from robot_agent.recording.run_header import RunHeader
from tools.logs.recording import read_recording

HEADER = RunHeader(robot="r", team="t", seed=1, software_version="", start_wall_ns=0)


def make_runs(folder: Path, count: int, size: int) -> NumberedRuns:
    """Make whole runs, the newest with the oldest time of change; return them, the last open."""
    runs = NumberedRuns(folder, "r")
    for number in range(count):
        with runs.open_next() as file:
            file.write(bytes(size))
        os.utime(runs.path, (1000 - number, 1000 - number))
    return runs


def room(runs: RunFiles, keep_mb: float = 1e9, leave_free_mb: float = 0.0) -> RecordingRetention:
    return RecordingRetention(runs, RecorderSettings(keep_mb=keep_mb, leave_free_mb=leave_free_mb))


def numbers(folder: Path) -> list[int]:
    return sorted(int(path.name.split("-")[1]) for path in folder.glob("r-*"))


def test_oldest_runs_by_number_are_deleted_whatever_their_times(tmp_path: Path) -> None:
    runs = make_runs(tmp_path, 6, 200_000)
    (tmp_path / "other.mcap").write_bytes(bytes(9_000_000))
    assert room(runs, keep_mb=0.9).free_space() == ""
    assert numbers(tmp_path) == [3, 4, 5, 6]
    assert (tmp_path / "other.mcap").exists()


def test_last_three_runs_are_kept(tmp_path: Path) -> None:
    runs = make_runs(tmp_path, 3, 400_000)
    assert "keep_mb = 1 is used up by the last 3 runs" in room(runs, keep_mb=1.0).free_space()
    assert numbers(tmp_path) == [1, 2, 3]


def test_nothing_is_deleted_where_that_does_not_reach_the_limit(tmp_path: Path) -> None:
    runs = make_runs(tmp_path, 7, 200_000)
    assert "leave_free_mb" in room(runs, leave_free_mb=1e12).free_space()
    assert "keep_mb" in room(runs, keep_mb=0.5).free_space()
    assert numbers(tmp_path) == [1, 2, 3, 4, 5, 6, 7]


def test_file_of_the_users_choice_has_no_older_runs(tmp_path: Path) -> None:
    make_runs(tmp_path, 7, 2_000_000)
    file = OneFile(tmp_path / "run.mcap")
    file.open_next().close()
    assert room(file, keep_mb=1.0).free_space() == ""
    assert len(numbers(tmp_path)) == 7


def wait_for(condition: Callable[[], bool]) -> None:
    """Wait for the recorder's thread."""
    end = time.monotonic() + 20.0
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.001)


def test_nearly_full_disk_pauses_the_recording_and_ends_it_orderly(tmp_path: Path) -> None:
    file = OneFile(tmp_path / "run.mcap")
    recorder = Recorder(file, HEADER, flush_period=0.01, room=room(file, leave_free_mb=1e12))
    wait_for(lambda: bool(recorder.failed))
    recorder.record_event(Tick(1.0))
    recorder.close()
    assert "make room" in recorder.failed
    assert recorder.lost == 1
    recording = read_recording(file.path)
    assert list(recording.items()) == [Gap(1.0, 1)]
    assert recording.truncated is None


def test_recording_goes_on_after_a_marked_gap_when_there_is_room_again(tmp_path: Path) -> None:
    runs = make_runs(tmp_path, 2, 15 * MEGABYTE)
    keep = room(runs, keep_mb=26.0)  # what is there takes it up, and may not be deleted
    recorder = Recorder(
        runs, HEADER, drain_period=0.001, flush_period=0.01, retry_after=0.01, room=keep
    )
    with closing(recorder):
        wait_for(lambda: bool(recorder.failed))
        recorder.record_event(Tick(1.0))
        recorder.record_event(Tick(2.0))
        runs.older()[0].unlink()  # a person makes room
        wait_for(lambda: not recorder.failed)
        recorder.record_event(Tick(3.0))
    assert list(read_recording(runs.path).items()) == [Gap(3.0, 2), Tick(3.0)]
    assert (recorder.failed, recorder.lost) == ("", 2)


def test_unwritable_folder_is_told_and_recording_begins_when_it_can_be_made(tmp_path: Path) -> None:
    (tmp_path / "records").write_text("in the way")
    runs = NumberedRuns(tmp_path / "records", "r")
    recorder = Recorder(runs, HEADER, drain_period=0.001, retry_after=0.01, room=room(runs))
    with closing(recorder):
        wait_for(lambda: bool(recorder.failed))
        assert "records: recording stopped: " in recorder.failed
        recorder.record_event(Tick(2.0))
        (tmp_path / "records").unlink()
        wait_for(lambda: not recorder.failed)
        recorder.record_event(Tick(3.0))
    assert runs.path.name.startswith("r-000001-")
    assert list(read_recording(runs.path).items()) == [Gap(3.0, 1), Tick(3.0)]


@pytest.mark.parametrize("settings", [{"keep_mb": 0.0}, {"leave_free_mb": -1.0}])
def test_invalid_limits_raise(settings: dict[str, float]) -> None:
    with pytest.raises(msgspec.ValidationError):
        msgspec.convert(settings, RecorderSettings)
