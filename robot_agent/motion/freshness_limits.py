"""Freshness limits of the streams that motion depends on: rate, maximum age, reaction.

This table is the single source of these figures: gate, alarms and the table in this room's README
are derived from it.
"""

from __future__ import annotations

from dataclasses import dataclass

from robot_agent.messages.log_level import LogLevel


@dataclass(frozen=True, slots=True)
class FreshnessLimit:
    """Limit of one stream that motion depends on."""

    name: str
    what: str
    """Name for people."""
    rate: float
    """Hz, minimum in normal operation."""
    max_age: float
    """s after which it is stale."""
    reaction: str
    """What the robot does then, for people."""
    level: LogLevel
    """Of the alarm."""


BASE = FreshnessLimit("base", "base report", 10.0, 0.28, "the robot stands", LogLevel.ERROR)
LASER = FreshnessLimit("laser", "laser scan", 9.0, 0.34, "the robot stands", LogLevel.ERROR)
SONAR = FreshnessLimit(
    "sonar", "sonar echo", 3.0, 0.5, "old echoes are forgotten", LogLevel.WARNING
)
POSE = FreshnessLimit(
    *("pose", "localized pose", 5.0, 1.0),
    "unsure: the robot is slow; lost: it stands, then turns slowly to find itself",
    LogLevel.WARNING,
)
FROZEN_BASE = 2
"""Reports in a row with a speed but an unchanged pose: five encoder counts at the lowest speed."""
FROZEN_LASER = 2
"""Scans in a row equal to the last one, beam for beam, while the robot moves."""
MIN_RETURNS = 0.05
"""Share of beams with a return; a scan with less comes from a blind laser and is rejected."""

_LOST_SCANS, _SCAN_SLACK = 1, 0.02  # scans; s
SHORTEST_SCAN_AGE, LONGEST_SCAN_AGE = 0.2, 0.45  # s


def scan_age_limit(period: float) -> float:
    """Return the maximum age, s, of a scan for a laser with a scan ``period``, s.

    A scan is one period old when its transmission ends and two when the next one arrives, and one
    scan may be lost; that gives LASER.max_age at 38400 baud. The result is at most
    LONGEST_SCAN_AGE: with a slower laser the robot stops at every lost scan, and below 4.5 scans/s
    scans are always stale.
    """
    limit = (2 + _LOST_SCANS) * period + _SCAN_SLACK
    return min(max(limit, SHORTEST_SCAN_AGE), LONGEST_SCAN_AGE)


CONTROL = FreshnessLimit(
    *("control", "control step in time", 10.0, 0.1),
    "three late within 3 s: the robot stands until they are older than that",
    LogLevel.ERROR,
)
CALM_S = 2.0
"""s without a gap after which a stream counts as fresh again: one that is too slow for its limit,
like a laser left at 9600 baud, would else be told of at every scan."""
STREAMS = (BASE, LASER, SONAR, POSE)
LIMITS = (*STREAMS, CONTROL)


class FreshnessWatch:
    """Watchdog of the streams: reports when one becomes stale and when it is fresh again."""

    def __init__(self) -> None:
        """Start without data; a stream cannot become stale before its first data."""
        self._valid_at: dict[str, float] = {}
        self._stale: dict[str, float] = {}  # since when each has been without a gap

    def mark_valid(self, stream: FreshnessLimit, t: float) -> None:
        """Record valid data of a stream at t."""
        self._valid_at[stream.name] = t

    def changes(self, t: float) -> list[tuple[FreshnessLimit, bool]]:
        """Return the streams that have become stale (False) or fresh again (True) by t.

        Each change is returned once.
        """
        found = []
        for stream in STREAMS:
            well = t - self._valid_at.get(stream.name, t) <= stream.max_age
            if not well and stream.name not in self._stale:
                found.append((stream, False))
            if not well:
                self._stale[stream.name] = t
            elif t - self._stale.get(stream.name, t) >= CALM_S:
                found.append((stream, True))
                del self._stale[stream.name]
        return found


def markdown() -> str:
    """Return the limits as a Markdown table, as in this room's README."""
    lines = ["| Stream | at least, Hz | trusted for, s | then |", "| --- | --- | --- | --- |"]
    lines += [
        f"| {each.what} | {each.rate:g} | {each.max_age:g} | {each.reaction} |" for each in LIMITS
    ]
    return "\n".join(lines)
