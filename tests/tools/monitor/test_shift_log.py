"""The shift log: kept over restarts, filtered, exported, and no trouble for anybody."""

from __future__ import annotations

import csv
import io
import json
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from tools.commands.monitor import log_file
from tools.monitor.alarm import Condition, Severity
from tools.monitor.alarm_board import Alarm, AlarmBoard
from tools.monitor.log_export import log_csv, log_json
from tools.monitor.shift_log import LogFilter, ShiftLog, ShiftLogError
from tools.monitor.sighting import Sighting

NOON = 1_700_000_000.0
PICTURE = b"\xff\xd8\xff picture"


def raised(
    kind: str, severity: Severity = Severity.WARNING, robot: str = "north/anna"
) -> Condition:
    return Condition(robot, kind, severity, f"{kind} of {robot}", place=(1.0, -2.0))


def shift(log: ShiftLog) -> AlarmBoard:
    """Raise three alarms a minute apart; acknowledge the first; the others are over."""
    board = AlarmBoard(log.put)
    seen = Sighting(3.0, 4.0, NOON, PICTURE)
    conditions = (
        raised("battery"),
        Condition("north/bob", "intruder", Severity.CRITICAL, "intruder", sighting=seen),
        raised("stray", robot=""),
    )
    for minute, condition in enumerate(conditions):
        board.update([condition], 60.0 * minute, NOON + 60.0 * minute)
    board.acknowledge(1, "Mia", NOON + 100.0)
    return board


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A log of one shift, closed."""
    path = tmp_path / "shift_log.sqlite"
    with closing(ShiftLog(path)) as log:
        shift(log)
    return path


def test_log_is_kept_over_a_restart_and_each_alarm_is_one_entry(file: Path) -> None:
    with closing(ShiftLog(file)) as log:
        entries = log.entries(LogFilter(), 100)
        assert [entry.kind for entry in entries] == ["stray", "intruder", "battery"]
        battery = entries[-1]
        assert (battery.raised, battery.cleared) == (NOON, NOON + 60.0)
        assert (battery.acknowledged, battery.acknowledged_by) == (NOON + 100.0, "Mia")
        assert (battery.place_x, battery.place_y) == (1.0, -2.0)
        assert entries[0].cleared is None, "it was raised when that monitor ended"
        shift(log)
    with closing(ShiftLog(file)) as log:
        assert len(log.entries(LogFilter(), 100)) == 6
        assert len({entry.run for entry in log.entries(LogFilter(), 100)}) == 2


@pytest.mark.parametrize(
    ("wanted", "kinds"),
    [
        (LogFilter(words="MIA"), ["battery"]),
        (LogFilter(words="of north"), ["battery"]),
        (LogFilter(words="%"), []),
        (LogFilter(robot="north/bob"), ["intruder"]),
        (LogFilter(least=Severity.CRITICAL), ["intruder"]),
        (LogFilter(since=NOON + 30.0), ["stray", "intruder"]),
        (LogFilter(until=NOON + 30.0), ["battery"]),
        (LogFilter(words="'; DROP TABLE alarms; --"), []),
    ],
)
def test_filter_keeps_what_is_asked_for(file: Path, wanted: LogFilter, kinds: list[str]) -> None:
    with closing(ShiftLog(file)) as log:
        assert [entry.kind for entry in log.entries(wanted, 100)] == kinds


def test_picture_of_an_intruder_is_kept(file: Path) -> None:
    with closing(ShiftLog(file)) as log:
        pictured = {entry.kind: entry.pictured for entry in log.entries(LogFilter(), 100)}
        assert pictured == {"stray": False, "intruder": True, "battery": False}
        (intruder,) = log.entries(LogFilter(words="intruder"), 1)
        assert log.picture(intruder.id) == PICTURE
        assert log.picture(999) == b""


def test_exported_cells_are_no_formulas(tmp_path: Path) -> None:
    with closing(ShiftLog(tmp_path / "log.sqlite")) as log:
        board = AlarmBoard(log.put)
        board.update([Condition("", "x", Severity.INFO, "=cmd|' /C calc'!A0\x1b[2J")], 0.0, NOON)
        board.acknowledge(1, "@SUM(1)", NOON)
    with closing(ShiftLog(tmp_path / "log.sqlite")) as log:
        entries = log.entries(LogFilter(), 9)
    (row,) = csv.DictReader(io.StringIO(log_csv(entries)))
    assert row["text"] == "'=cmd|' /C calc'!A0\\x1b[2J"
    assert row["acknowledged_by"] == "'@SUM(1)"
    assert row["raised"].startswith("2023-11-1")
    assert json.loads(log_json(entries))[0]["raised"] == NOON


def test_log_without_a_file_lasts_for_one_run() -> None:
    log = ShiftLog(None)
    shift(log)
    log.close()


@pytest.fixture
def full() -> Path:
    path = Path("/dev/full")
    if not path.exists():
        pytest.skip("no /dev/full here")
    return path


def test_file_that_cannot_be_used_is_one_error(tmp_path: Path, full: Path) -> None:
    noise = tmp_path / "noise.sqlite"
    noise.write_bytes(b"no database at all" * 100)
    other = tmp_path / "other.sqlite"
    with closing(sqlite3.connect(other)) as database:
        database.execute("CREATE TABLE alarms (id INTEGER)")
    for path in (noise, other, tmp_path / "missing" / "log.sqlite", full):
        with pytest.raises(ShiftLogError, match="--log"):
            ShiftLog(path)


def test_disk_error_is_told_and_ends_the_writing(tmp_path: Path) -> None:
    path = tmp_path / "log.sqlite"
    with closing(ShiftLog(path)) as log:
        log._database.execute("PRAGMA query_only = ON")  # as a file system that turned read-only
        log.put(Alarm(1, "", "x", Severity.INFO, "words", 0.0, NOON))
    assert "shift log stopped" in log.failed


def test_log_lies_beside_the_recording_unless_it_is_named() -> None:
    record, named = Path("runs/team.mcap"), Path("log.sqlite")
    assert log_file(None, None) is None
    assert log_file(None, record) == Path("runs/shift_log.sqlite")
    assert log_file(named, record) == named
