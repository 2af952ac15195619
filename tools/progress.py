"""A progress line on standard error, shown on terminals only."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

PERIOD_S = 0.2
WIDTH = 30


@contextmanager
def progress_line(
    label: str, total: float | None, unit: str = ""
) -> Iterator[Callable[[float], None]]:
    """Yield a function that takes the amount done; the line is cleared on every way out.

    label: name of the work; total: its size in ``unit``, None if not known beforehand.
    """
    line = _Line(label, total, unit)
    try:
        yield line.show
    finally:
        line.clear()


class _Line:
    """A progress bar on one line; prints nothing unless standard error is a terminal."""

    def __init__(self, label: str, total: float | None, unit: str) -> None:
        self._label = label
        self._total = total
        self._unit = unit
        self._shown_at = 0.0
        self._visible = sys.stderr.isatty()

    def show(self, done: float) -> None:
        """Show the amount done; at most one update per ``PERIOD_S``."""
        now = time.monotonic()
        if not self._visible or now - self._shown_at < PERIOD_S:
            return
        self._shown_at = now
        print(f"\r{self._text(done)}", end="", file=sys.stderr, flush=True)

    def _text(self, done: float) -> str:
        if not self._total:
            return f"{self._label} {done:.0f} {self._unit}"
        bar = "#" * round(min(done / self._total, 1.0) * WIDTH)
        return f"{self._label} [{bar:<{WIDTH}}] {done:.0f}/{self._total:.0f} {self._unit}"

    def clear(self) -> None:
        """Erase the line."""
        if self._visible:
            print("\r\033[K", end="", file=sys.stderr, flush=True)
