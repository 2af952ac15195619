"""The shift log as a file: CSV for spreadsheets, JSON for programs."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from datetime import datetime

import msgspec

from tools.logs.csv_cells import csv_cells
from tools.monitor.shift_log import LogEntry

_HEADINGS = (
    "raised", "cleared", "severity", "robot", "kind", "text", "x_m", "y_m", "acknowledged",
    "acknowledged_by",
)  # fmt: skip


def log_csv(entries: Sequence[LogEntry]) -> str:
    """Return the entries as CSV with headings; no cell is a formula; times with their zone."""
    out = io.StringIO(newline="")
    writer = csv.writer(out)
    writer.writerow(_HEADINGS)
    for entry in entries:
        writer.writerow(
            csv_cells(
                (
                    *(_time(entry.raised), _time(entry.cleared), entry.severity, entry.robot),
                    *(entry.kind, entry.text, _metres(entry.place_x), _metres(entry.place_y)),
                    *(_time(entry.acknowledged), entry.acknowledged_by),
                )
            )
        )
    return out.getvalue()


def log_json(entries: Sequence[LogEntry]) -> bytes:
    """Return the entries as a JSON list of objects; times in s since 1970."""
    return msgspec.json.encode(entries)


def _time(wall: float | None) -> str:
    if wall is None:
        return ""
    return datetime.fromtimestamp(wall).astimezone().isoformat(timespec="seconds")


def _metres(value: float | None) -> float | str:
    return "" if value is None else round(value, 2)
