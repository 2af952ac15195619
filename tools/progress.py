"""A progress line on standard error, shown only to people."""

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
    """Give what is told how much is done; the line is cleared on every way out.

    label, total, unit: the work and its size, None where that is not known beforehand.
    """
    line = _Line(label, total, unit)
    try:
        yield line.show
    finally:
        line.clear()


class _Line:
    """One line that fills up; silent unless standard error is a terminal."""

    def __init__(self, label: str, total: float | None, unit: str) -> None:
        self._label = label
        self._total = total
        self._unit = unit
        self._shown_at = 0.0
        self._visible = sys.stderr.isatty()

    def show(self, done: float) -> None:
        """Show how much is done, a few times a second."""
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
        """Take the line away."""
        if self._visible:
            print("\r\033[K", end="", file=sys.stderr, flush=True)
