"""The progress line: drawn anew on terminals and cleared on every way out, else one a minute."""

from __future__ import annotations

import io
import sys

import pytest

from tools.progress import progress_line


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_line_is_shown_and_cleared_after_an_exception(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = Terminal()
    monkeypatch.setattr(sys, "stderr", screen)

    def begin() -> None:
        with progress_line("map", 4, "scans") as progress:
            progress(2)
            raise RuntimeError

    with pytest.raises(RuntimeError):
        begin()
    assert "map [###############               ] 2/4 scans" in screen.getvalue()
    assert screen.getvalue().endswith("\r\033[K")


def test_a_line_a_minute_is_printed_where_there_is_no_terminal(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    log, now = io.StringIO(), [0.0]
    monkeypatch.setattr(sys, "stderr", log)
    monkeypatch.setattr("tools.progress.time.monotonic", lambda: now[0])
    with progress_line("bench", 600.0, "s") as progress:
        for second in range(150):
            now[0] = float(second)
            progress(2.0 * second)
    bar = "#" * 6
    assert log.getvalue().splitlines() == [
        f"bench [{bar:<30}] 120/600 s",
        f"bench [{2 * bar:<30}] 240/600 s",
    ]


def test_nothing_is_printed_of_short_work_where_there_is_no_terminal(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    log = io.StringIO()
    monkeypatch.setattr(sys, "stderr", log)
    with progress_line("map", None) as progress:
        progress(2)
    assert log.getvalue() == ""
