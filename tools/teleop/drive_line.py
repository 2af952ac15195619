"""One line beneath the messages of a drive by keys: speed, distance, recorded size."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

from drivers.p2os.base_state import BaseState

PERIOD_S = 0.25
_CLEAR = "\r\033[K"


class Distance:
    """Way of the base, summed over reports that are taken now and then."""

    def __init__(self) -> None:
        self.driven = 0.0
        """m."""
        self._last: tuple[float, float] | None = None

    def take(self, state: BaseState) -> None:
        """Add the way since the last report taken."""
        if self._last is not None:
            self.driven += math.dist(self._last, (state.x, state.y))
        self._last = (state.x, state.y)


class LineBelow:
    """An output whose messages stand above one line that is drawn anew; thread-safe."""

    def __init__(self, out: TextIO) -> None:
        """out: a terminal."""
        self._out = out
        self._line = ""
        self._lock = threading.Lock()

    def write(self, text: str) -> None:
        """Write a part of a message above the line."""
        with self._lock:
            if self._line:
                self._out.write(_CLEAR)
                self._line = ""
            self._out.write(text)

    def flush(self) -> None:
        """Write out what was written."""
        self._out.flush()

    def show(self, line: str) -> None:
        """Draw the line; an empty one clears it."""
        with self._lock:
            if line != self._line:
                self._out.write(f"{_CLEAR}{line}")
                self._out.flush()
                self._line = line


def line_words(state: BaseState | None, distance: Distance, recorded: int) -> str:
    """Return the line; recorded: bytes."""
    motion = "no report of the base yet"
    if state is not None:
        turning = f"{math.degrees(state.w):+.0f} deg/s"
        motion = f"{state.v:.2f} m/s   {turning}   driven {distance.driven:.1f} m"
    return f"{motion}   recorded {recorded / 1e6:.1f} MB"


def size_of(path: Path) -> int:
    """Return a file's size, bytes; 0 before it is there."""
    try:
        return path.stat().st_size
    except OSError:
        return 0


@contextmanager
def drive_line(
    below: LineBelow, latest: Callable[[], BaseState | None], recorded: Callable[[], int]
) -> Iterator[None]:
    """Keep the line up to date on a thread while the context lasts; it is cleared after it.

    latest: returns the newest report of the base. recorded: returns the recorded bytes.
    """
    ending = threading.Event()

    def draw() -> None:
        distance = Distance()
        while not ending.wait(PERIOD_S):
            state = latest()
            if state is not None:
                distance.take(state)
            below.show(line_words(state, distance, recorded()))
        below.show("")

    thread = threading.Thread(target=draw, name="drive line", daemon=True)
    thread.start()
    try:
        yield
    finally:
        ending.set()
        thread.join()
