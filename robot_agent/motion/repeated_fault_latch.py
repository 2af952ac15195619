"""Latch of repeated faults (bumper, stall), to be cleared by a person at the robot."""

from __future__ import annotations


class RepeatedFaultLatch:
    """Latches at a number of strikes within a time; ``release`` clears it.

    A strike is the begin of a fault. Strikes while the stop button is pressed do not count, as a
    person is at the robot then.
    """

    def __init__(self, strikes: int, within: float) -> None:
        """strikes: number that latches; within: s."""
        self._limit = strikes
        self._within = within
        self._struck = False
        self._times: list[float] = []
        self.latched = False

    def update(self, t: float, *, struck: bool, held: bool) -> None:
        """Process a report at t. struck: the fault is present; held: the stop button is pressed."""
        if struck and not self._struck and not held:
            self._times = [time for time in self._times if t - time < self._within] + [t]
            self.latched = self.latched or len(self._times) >= self._limit
        self._struck = struck

    def release(self) -> None:
        """Clear the latch and all strikes."""
        self.latched = False
        self._times.clear()
