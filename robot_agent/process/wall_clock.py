"""Whether this computer's wall clock was set: robots' computers have no clock battery."""

from __future__ import annotations

import datetime

EARLIEST_YEAR = 2025
"""A wall clock before this year is not set: this program is newer."""
SET_IT = "`sudo date -s ...`, or let the operator's machine serve the time"


def clock_trouble(wall: float) -> str:
    """Return that a wall clock, s since 1970, is not set, with remedy; empty if it may be."""
    now = datetime.datetime.fromtimestamp(wall, datetime.UTC)
    if now.year >= EARLIEST_YEAR:
        return ""
    return f"the clock is not set, it says {now.year}: times are wrong; {SET_IT}"
