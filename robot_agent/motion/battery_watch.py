"""Whether the battery is too low to drive."""

from __future__ import annotations


class BatteryWatch:
    """Low once below one voltage for a while, until above another.

    Motors that start pull the voltage down for a moment, and it recovers when they rest: neither
    may count.
    """

    def __init__(self, cutoff: float, resume: float, patience: float) -> None:
        """Low below ``cutoff`` V for ``patience`` s, well again from ``resume`` V."""
        self._cutoff = cutoff
        self._resume = resume
        self._patience = patience
        self._below_since: float | None = None
        self.low = False

    def update(self, t: float, volts: float) -> None:
        """Take the voltage at ``t``, s."""
        if volts >= self._cutoff:
            self._below_since = None
            self.low = self.low and volts < self._resume
            return
        if self._below_since is None:
            self._below_since = t
        self.low = self.low or t - self._below_since >= self._patience
