"""The progress line: shown on terminals only, cleared on every way out."""

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


def test_nothing_is_printed_where_there_is_no_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    log = io.StringIO()
    monkeypatch.setattr(sys, "stderr", log)
    with progress_line("map", None) as progress:
        progress(2)
    assert log.getvalue() == ""
