"""The shift log: every alarm of all runs of a monitor, in an SQLite file that outlives them.

Alarms are queued and written by a thread of its own: a slow disk holds up nobody.
"""

from __future__ import annotations

import secrets
import sqlite3
import threading
import time
from collections import deque
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from tools.monitor.alarm import Severity
from tools.monitor.alarm_board import Alarm

KEPT = 100_000
"""Entries kept, the newest: years of shifts, and under 100 MB."""
_WRITE_S = 0.2
_MAX_WAITING = 10_000
_SELECT = """
SELECT id, run, number, raised, cleared, robot, kind, severity, text, place_x, place_y,
    acknowledged, acknowledged_by, length(picture) > 0 FROM alarms """
_MAKE = """
CREATE TABLE IF NOT EXISTS alarms (
    id INTEGER PRIMARY KEY, run TEXT NOT NULL, number INTEGER NOT NULL, raised REAL NOT NULL,
    cleared REAL, robot TEXT NOT NULL, kind TEXT NOT NULL,
    severity INTEGER NOT NULL CHECK (severity BETWEEN 1 AND 3), text TEXT NOT NULL,
    place_x REAL, place_y REAL, acknowledged REAL, acknowledged_by TEXT NOT NULL,
    picture BLOB NOT NULL, UNIQUE (run, number)
)"""
_PUT = """
INSERT INTO alarms (run, number, raised, cleared, robot, kind, severity, text, place_x, place_y,
    acknowledged, acknowledged_by, picture)
VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)
ON CONFLICT (run, number) DO UPDATE SET cleared = excluded.cleared, severity = excluded.severity,
    text = excluded.text, place_x = excluded.place_x, place_y = excluded.place_y,
    acknowledged = excluded.acknowledged, acknowledged_by = excluded.acknowledged_by,
    picture = excluded.picture"""


_SEARCHED = "text || ' ' || robot || ' ' || kind || ' ' || acknowledged_by"


class ShiftLogError(ValueError):
    """The file cannot be used; the message names it, the reason and the remedy."""


class LogEntry(msgspec.Struct, frozen=True):
    """One alarm in the log; times in s since 1970, places in m in the map frame."""

    id: int
    run: str  # of the monitor, the time it began; an alarm of an earlier one may lack its end
    number: int  # of the alarm in its run
    raised: float
    cleared: float | None
    robot: str  # team/name; empty: the monitor itself
    kind: str
    severity: str
    text: str
    place_x: float | None
    place_y: float | None
    acknowledged: float | None
    acknowledged_by: str
    pictured: bool  # whether there is a picture


@dataclass(frozen=True, slots=True)
class LogFilter:
    """What entries are wanted; None and empty: all."""

    words: str = ""  # in text, robot, kind or name of who acknowledged
    robot: str = ""
    least: Severity = Severity.INFO
    since: float | None = None  # s since 1970, of ``raised``
    until: float | None = None


class ShiftLog:
    """A log; thread-safe.

    ``failed`` is empty, or one line with the reason why nothing is written any more. ``version``
    changes with each change of the entries.
    """

    def __init__(self, path: Path | None) -> None:
        """Open a log, or make it; path None: kept in memory, for this run only.

        Raises ShiftLogError.
        """
        self.path = path
        self.failed = ""
        self.version = 0
        self.run = f"{time.strftime('%Y-%m-%d %H:%M:%S')} {secrets.token_hex(3)}"
        self._lock = threading.Lock()
        self._waiting: deque[Alarm] = deque(maxlen=_MAX_WAITING)  # some more than once
        self._database = _open(path)
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._write_on, name="shift log", daemon=True)
        self._thread.start()

    def put(self, alarm: Alarm) -> None:
        """Queue an alarm that is new or has changed; takes microseconds."""
        self._waiting.append(alarm)

    def entries(self, wanted: LogFilter, limit: int) -> list[LogEntry]:
        """Return the newest entries of a filter, the newest first; from any thread."""
        conditions, values = _conditions(wanted)
        query = f"{_SELECT} {conditions} ORDER BY raised DESC, id DESC LIMIT ?"
        with self._lock:
            rows = self._database.execute(query, (*values, limit)).fetchall()
        return [_entry(row) for row in rows]

    def picture(self, entry: int) -> bytes:
        """Return the picture of an entry, JPEG; empty if it has none."""
        with self._lock:
            found = self._database.execute("SELECT picture FROM alarms WHERE id = ?", (entry,))
            row = found.fetchone()
        return b"" if row is None else bytes(row[0])

    def close(self) -> None:
        """Write what is queued and close the file; idempotent."""
        self._ending.set()
        self._thread.join()
        self._database.close()

    # --- the log's thread ------------------------------------------------------------------------

    def _write_on(self) -> None:
        ending = False
        while not ending:
            ending = self._ending.wait(_WRITE_S)
            waiting = [self._waiting.popleft() for _ in range(len(self._waiting))]
            newest = {alarm.number: alarm for alarm in waiting}
            if newest and not self.failed:
                self._write(list(newest.values()))

    def _write(self, alarms: Sequence[Alarm]) -> None:
        try:
            with self._lock, self._database:
                self._database.executemany(_PUT, [_row(self.run, alarm) for alarm in alarms])
                self._database.execute(
                    "DELETE FROM alarms WHERE id <= (SELECT max(id) FROM alarms) - ?", (KEPT,)
                )
        except sqlite3.Error as error:
            self.failed = f"{self.path}: shift log stopped: {error}"
        self.version += 1


def _open(path: Path | None) -> sqlite3.Connection:
    name = ":memory:" if path is None else str(path)
    with ExitStack() as stack:
        try:
            database = sqlite3.connect(name, check_same_thread=False, timeout=2.0)
            stack.callback(database.close)
            database.execute("PRAGMA journal_mode = WAL")  # a change every second costs no sync
            database.execute("PRAGMA synchronous = NORMAL")
            with database:
                database.execute(_MAKE)
                database.execute("CREATE INDEX IF NOT EXISTS by_time ON alarms (raised)")
            database.execute(f"{_SELECT} LIMIT 1").fetchall()  # a file of ours, not another's
        except sqlite3.Error as error:
            raise ShiftLogError(
                f"{path}: cannot keep the shift log there ({error}); give another file with --log"
            ) from error
        stack.pop_all()
    return database


def _row(run: str, alarm: Alarm) -> tuple[object, ...]:
    place = alarm.place if alarm.sighting is None else alarm.sighting.place
    x, y = (None, None) if place is None else place
    acknowledged = alarm.acknowledged_wall if alarm.acknowledged else None
    picture = b"" if alarm.sighting is None else alarm.sighting.picture
    return (
        *(run, alarm.number, alarm.raised_wall, alarm.cleared_wall, alarm.robot, alarm.kind),
        *(int(alarm.severity), alarm.text, x, y, acknowledged, alarm.acknowledged_by, picture),
    )


def _entry(row: Sequence[Any]) -> LogEntry:
    fields = dict(zip(LogEntry.__struct_fields__, row, strict=True))
    fields["severity"] = Severity(int(fields["severity"])).name.lower()
    fields["pictured"] = bool(fields["pictured"])
    return msgspec.convert(fields, LogEntry)


def _conditions(wanted: LogFilter) -> tuple[str, list[object]]:
    """Return the WHERE clause of a filter, and its values."""
    parts: list[str] = ["severity >= ?"]
    values: list[object] = [int(wanted.least)]
    if wanted.words:
        parts.append(f"instr(lower({_SEARCHED}), ?)")
        values.append(wanted.words.lower())
    if wanted.robot:
        parts.append("robot = ?")
        values.append(wanted.robot)
    for comparison, value in ((">=", wanted.since), ("<=", wanted.until)):
        if value is not None:
            parts.append(f"raised {comparison} ?")
            values.append(value)
    return "WHERE " + " AND ".join(parts), values
