"""What is read out of a machine's journal, from canned lines of journalctl."""

from __future__ import annotations

from tools.field.journal import JournalLine, lines_an_hour, says, starts

UNIT = "patrol@robot1.service - Border patrol agent robot1"
LINES = [
    JournalLine(4.7, "systemd", f"Starting {UNIT}..."),
    JournalLine(8.6, "patrol-robot1", "base: port open"),
    JournalLine(8.6, "patrol-robot1", "gate: Starting is no start"),
    JournalLine(14.0, "systemd", "patrol@robot1.service: Scheduled restart job"),
    JournalLine(14.1, "systemd", f"Starting {UNIT}..."),
]


def test_a_line_is_read_from_journalctls_json() -> None:
    fields = {
        "__MONOTONIC_TIMESTAMP": "8553065",
        "SYSLOG_IDENTIFIER": "patrol-robot1",
        "MESSAGE": "base: port open",
    }
    assert JournalLine.of(fields) == JournalLine(8.553065, "patrol-robot1", "base: port open")


def test_starts_are_counted_by_systemds_lines_alone() -> None:
    assert starts(LINES) == 2


def test_lines_an_hour_counts_those_within() -> None:
    assert lines_an_hour(LINES, 8.0, 12.0) == 2 / 4.0 * 3600.0
    assert lines_an_hour(LINES, 20.0, 80.0) == 0.0


def test_words_are_found_in_any_line() -> None:
    assert says(LINES, "port open")
    assert not says(LINES, "laser")
