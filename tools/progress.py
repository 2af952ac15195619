"""A progress line on standard error, shown only to people."""

from __future__ import annotations

import sys
import time

PERIOD_S = 0.2
WIDTH = 30


class Progress:
    """One line that fills up; silent unless standard error is a terminal."""

    def __init__(self, label: str, total: float | None, unit: str = "") -> None:
        """Name the work and its size in ``unit``, None where it is not known beforehand."""
        self._label = label
        self._total = total
        self._unit = unit
        self._shown_at = 0.0
        self._visible = sys.stderr.isatty()

    def __call__(self, done: float) -> None:
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

    def __enter__(self) -> Progress:
        """Use as a context, so that the line is cleared on every way out."""
        return self

    def __exit__(self, *_: object) -> None:
        """Clear the line."""
        if self._visible:
            print("\r\033[K", end="", file=sys.stderr, flush=True)
