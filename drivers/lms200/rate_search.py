"""The order in which rates are tried to find a laser."""

from __future__ import annotations

COMMON_RATES = (38400, 9600, 19200, 500000)
"""All that an LMS 200 knows, likeliest first."""


class RateSearch:
    """Selects the rate to try; ``baud`` is the present one.

    A laser just switched on has its own rate and not the wanted one: the first sweep is a quick
    look at each rate, the second makes all tries. The rate at which scans last came is tried
    between any two others: a laser whose cable is plugged in again is still streaming at it.
    """

    def __init__(self, wanted: int) -> None:
        self.baud = wanted
        self._wanted = wanted
        self._streamed_at: int | None = None
        self._pending: list[int] = []
        self._thorough = 0  # of those pending, the last ones

    @property
    def glances(self) -> bool:
        """Whether one try at this rate is enough for now."""
        return len(self._pending) >= self._thorough

    @property
    def ends(self) -> bool:
        """Whether no rate is left to go to."""
        return not self._pending

    def restart(self, first: int) -> None:
        """Begin a search; ``advance`` goes to ``first``, baud, as the first rate."""
        rates = self._in_order(first)
        glances = rates if self._streamed_at is None else []
        self._pending = [*glances, *rates]
        self._thorough = len(rates)

    def advance(self) -> None:
        """Go to the next rate, of which there must be one."""
        self.baud = self._pending.pop(0)

    def on_scan(self) -> None:
        """Remember that scans come at the present rate."""
        self._streamed_at = self.baud

    def _in_order(self, first: int) -> list[int]:
        known = self._streamed_at
        order = [first]
        for rate in dict.fromkeys((self._wanted, *COMMON_RATES)):
            if rate in (first, known):
                continue
            if known is not None and order[-1] != known:
                order.append(known)
            order.append(rate)
        return order
