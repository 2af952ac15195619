"""Remembers blows that came too often: from then on a person has to look at the robot."""

from __future__ import annotations


class RepeatedFaultLatch:
    """Latches at so many strikes within so long; a person at the robot releases it.

    A strike begins when something is struck that was not before. Strikes while the stop button
    holds the robot do not count: somebody is at it.
    """

    def __init__(self, strikes: int, within: float) -> None:
        """Latch at that many ``strikes`` ``within`` so many s."""
        self._limit = strikes
        self._within = within
        self._struck = False
        self._times: list[float] = []
        self.latched = False

    def update(self, t: float, *, struck: bool, held: bool) -> None:
        """Take what a report at ``t``, s, says; ``held``: by the stop button."""
        if struck and not self._struck and not held:
            self._times = [time for time in self._times if t - time < self._within] + [t]
            self.latched = self.latched or len(self._times) >= self._limit
        self._struck = struck

    def release(self) -> None:
        """Forget everything: a person has looked."""
        self.latched = False
        self._times.clear()
