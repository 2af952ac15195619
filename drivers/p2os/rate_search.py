"""The order in which rates are tried to find a robot."""

from __future__ import annotations

COMMON_RATES = (9600, 38400, 19200, 115200, 57600)
"""Likeliest first, as in existing clients."""
TRIES = 2
TRIES_AT_KNOWN_RATE = 20


class RateSearch:
    """Selects the rate to try.

    The first sweep tries each rate in turn; later ones return to the configured rate after every
    other, so that a robot switched on late is found soon. The rate at which a robot has answered
    before is tried first, with more attempts.
    """

    def __init__(self, configured: int) -> None:
        self.all = [configured, *(rate for rate in COMMON_RATES if rate != configured)]
        """Every rate, in the order of the first sweep."""
        self.baud = configured
        self.tries = TRIES
        """Attempts to make at this rate before ``advance``."""
        self._known: int | None = None
        self._pending: list[int] = []

    def restart(self) -> None:
        """Begin a search from the first rate."""
        self.tries = TRIES if self._known is None else TRIES_AT_KNOWN_RATE
        self._pending = self.all.copy()
        if self._known is not None:
            self._pending.insert(0, self._known)
        self.baud = self._pending.pop(0)

    def on_success(self) -> None:
        """Remember that a robot answered at the present rate."""
        self._known = self.baud

    def return_to_configured(self) -> bool:
        """Go to the configured rate; return whether that is a change."""
        changed = self.baud != self.all[0]
        self.baud = self.all[0]
        return changed

    def advance(self) -> bool:
        """Go to the next rate; return whether that ended a sweep."""
        self.tries = TRIES
        ended = not self._pending
        if ended:
            configured, others = self.all[0], self.all[1:]
            self._pending = [rate for other in others for rate in (configured, other)]
        self.baud = self._pending.pop(0)
        return ended
