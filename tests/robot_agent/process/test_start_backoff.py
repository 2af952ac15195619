"""Starts that fail one after the other wait longer, but never for long."""

from pathlib import Path

import pytest

from robot_agent.process.start_backoff import HEALTHY_S, StartBackoff


def begin(folder: Path, now: float) -> float:
    return StartBackoff({"RUNTIME_DIRECTORY": str(folder)}).begin(now)


def test_pauses_grow_while_every_start_fails_and_end_at_half_a_minute(tmp_path):
    now, pauses = 1000.0, []
    for _ in range(10):
        pauses.append(begin(tmp_path, now))
        now += pauses[-1] + 2.0  # it fails two seconds after the pause
    assert pauses == [0.0, 0.0, 2.0, 4.0, 8.0, 16.0, 30.0, 30.0, 30.0, 30.0]


def test_agent_killed_in_its_pause_has_failed_too(tmp_path):
    pauses = [begin(tmp_path, 1000.0 + attempt) for attempt in range(5)]
    assert pauses == [0.0, 0.0, 2.0, 4.0, 8.0]


def test_start_after_a_healthy_minute_waits_for_nothing(tmp_path):
    now = 1000.0
    for _ in range(6):
        now += begin(tmp_path, now) + 2.0
    now += begin(tmp_path, now)
    assert begin(tmp_path, now + HEALTHY_S) == 0.0
    assert begin(tmp_path, now + HEALTHY_S + 1.0) == 0.0, "nor the first one that fails again"


def test_start_after_one_ended_on_purpose_waits_for_nothing(tmp_path):
    for now in (10.0, 11.0, 12.0):
        begin(tmp_path, now)
    StartBackoff({"RUNTIME_DIRECTORY": str(tmp_path)}).ended_well()
    assert [begin(tmp_path, now) for now in (13.0, 14.0)] == [0.0, 0.0]


@pytest.mark.parametrize("content", ["", "x y", "3", "3 nan", "-9 5", "\0", "99999 1e9"])
def test_damaged_file_stops_no_start(tmp_path, content):
    (tmp_path / "starts").write_text(content)
    assert 0.0 <= begin(tmp_path, 10.0) <= 30.0


def test_folder_that_takes_no_file_stops_no_start(tmp_path):
    assert begin(tmp_path / "none", 10.0) == 0.0


def test_agent_that_is_no_service_waits_for_nothing():
    backoff = StartBackoff({})
    assert backoff.begin(10.0) == 0.0
    backoff.ended_well()
