"""A progress line on standard error: drawn anew on terminals, once a minute elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

PERIOD_S = 0.2
LOG_PERIOD_S = 60.0
"""Period of the lines where standard error is no terminal."""
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
    """A progress bar on one line, or a line a minute if standard error is no terminal."""

    def __init__(self, label: str, total: float | None, unit: str) -> None:
        self._label = label
        self._total = total
        self._unit = unit
        self._redraws = sys.stderr.isatty()
        self._period = PERIOD_S if self._redraws else LOG_PERIOD_S
        self._shown_at = 0.0 if self._redraws else time.monotonic()

    def show(self, done: float) -> None:
        """Show the amount done; at most one update per period."""
        now = time.monotonic()
        if now - self._shown_at < self._period:
            return
        self._shown_at = now
        text = self._text(done)
        if self._redraws:
            print(f"\r{text}", end="", file=sys.stderr, flush=True)
        else:
            print(text, file=sys.stderr, flush=True)

    def _text(self, done: float) -> str:
        if not self._total:
            return f"{self._label} {done:.0f} {self._unit}"
        bar = "#" * round(min(done / self._total, 1.0) * WIDTH)
        return f"{self._label} [{bar:<{WIDTH}}] {done:.0f}/{self._total:.0f} {self._unit}"

    def clear(self) -> None:
        """Erase the line."""
        if self._redraws:
            print("\r\033[K", end="", file=sys.stderr, flush=True)
