"""Battery monitor: whether the voltage is too low to drive."""

from __future__ import annotations


class BatteryWatch:
    """Sets ``low`` below one voltage for some time, and clears it from a higher one.

    The debounce ignores the dip when motors start; the hysteresis ignores the recovery at rest.
    """

    def __init__(self, cutoff: float, resume: float, patience: float) -> None:
        """Low below ``cutoff`` V for ``patience`` s; cleared from ``resume`` V."""
        self._cutoff = cutoff
        self._resume = resume
        self._patience = patience
        self._below_since: float | None = None
        self.low = False

    def update(self, t: float, volts: float) -> None:
        """Process the voltage, V, at t."""
        if volts >= self._cutoff:
            self._below_since = None
            self.low = self.low and volts < self._resume
            return
        if self._below_since is None:
            self._below_since = t
        self.low = self.low or t - self._below_since >= self._patience
