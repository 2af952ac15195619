"""Whether a sensor only repeats itself while the robot moves."""

from __future__ import annotations


class FrozenWatch:
    """Frozen after some equal readings in a row while moving, until one differs."""

    def __init__(self, repeats: int) -> None:
        """Take how often in a row a reading must come again, while moving."""
        self._limit = repeats
        self._last: object = None
        self._repeats = 0

    @property
    def frozen(self) -> bool:
        """Whether the readings are not to be believed."""
        return self._repeats >= self._limit

    def update(self, reading: object, *, moving: bool) -> None:
        """Compare a reading with the one before."""
        if reading != self._last:
            self._last, self._repeats = reading, 0
        elif moving:
            self._repeats += 1
