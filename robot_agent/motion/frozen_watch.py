"""Detection of a frozen sensor, which repeats one reading while the robot moves."""

from __future__ import annotations


class FrozenWatch:
    """Latches after a number of equal readings in a row while moving, until one differs."""

    def __init__(self, repeats: int) -> None:
        """repeats: number of repetitions in a row, while moving, that count as frozen."""
        self._limit = repeats
        self._last: object = None
        self._repeats = 0

    @property
    def frozen(self) -> bool:
        """Whether the sensor is frozen, so that its readings are invalid."""
        return self._repeats >= self._limit

    def update(self, reading: object, *, moving: bool) -> None:
        """Process a reading; moving: whether the robot moved since the one before."""
        if reading != self._last:
            self._last, self._repeats = reading, 0
        elif moving:
            self._repeats += 1
