"""Whether this computer's wall clock was set: robots' computers have no clock battery."""

from __future__ import annotations

import datetime
from pathlib import Path

EARLIEST_YEAR = 2025
"""A wall clock before this year is not set: this program is newer."""
INSTALLED = Path(__file__).stat().st_mtime
"""When this program was installed, by the clock of that time, s since 1970.

systemd moves a clock without a battery on to the date of its own release, which passes for a date.
"""
DOUBT_S = 86400.0
"""By how much a set clock may be before the installation, s: ours; that clock was set by hand."""
SET_IT = "`sudo date -s ...`, or let the operator's machine serve the time"


def clock_trouble(wall: float, installed: float = INSTALLED) -> str:
    """Return that a wall clock, s since 1970, is not set, with remedy; empty if it may be."""
    now, then = (datetime.datetime.fromtimestamp(t, datetime.UTC) for t in (wall, installed))
    if now.year < EARLIEST_YEAR:
        return f"the clock is not set, it says {now.year}: times are wrong; {SET_IT}"
    if wall < installed - DOUBT_S:
        return (
            f"the clock is not set, it says {now:%Y-%m-%d}, and this program was installed "
            f"on {then:%Y-%m-%d}: times are wrong; {SET_IT}"
        )
    return ""
