"""The time that all robots of a team share, from each one's clock as it was set at deployment."""

from __future__ import annotations

import msgspec

DAY_S = 86400.0
_EARLIEST = 1735689600.0
"""s since 1970 at the begin of 2025: a clock before it was not set, as this program is newer."""


class CommonClock(msgspec.Struct, frozen=True):
    """Common time from agent time: at the agent's start, s since 1970, and the clock's drift.

    drift: s that the robot's clock gains in a day, as measured before.
    """

    start: float
    drift: float = 0.0

    def at(self, t: float) -> float:
        """Return the common time, s since 1970, at agent time t, s."""
        return self.start + t * (1.0 - self.drift / DAY_S)


def common_clock(start_wall_ns: int, drift: float) -> CommonClock | None:
    """Return the clock of a robot by its wall clock at agent time 0, ns since 1970; None if unset.

    0 is the clock of benches, which is right. drift: s a day that it gains.
    """
    start = start_wall_ns / 1e9
    return None if 0.0 < start < _EARLIEST else CommonClock(start, drift)
