"""What the agent depends on: how often it comes, how old it may get, what happens when it does.

This table is the only place of these figures: gate, alarms and the table of this room's README
come from it.
"""

from __future__ import annotations

from dataclasses import dataclass

from robot_agent.messages.log_level import LogLevel


@dataclass(frozen=True, slots=True)
class FreshnessLimit:
    """One stream that motion depends on."""

    name: str
    what: str
    rate: float
    """Hz, at least, when all is well."""
    max_age: float
    """s after which it is not trusted any more."""
    reaction: str
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
"""Reports in a row that tell of speed but not of motion: five counts at the least speed."""
FROZEN_LASER = 2
"""Scans in a row that are the last one again, beam for beam, while the robot moves."""
MIN_RETURNS = 0.05
"""Share of beams; a scan with less is that of a blind laser, and counts for none."""

_LOST_SCANS, _SCAN_SLACK = 1, 0.02  # the latter s
SHORTEST_SCAN_AGE, LONGEST_SCAN_AGE = 0.2, 0.45  # s


def scan_age_limit(period: float) -> float:
    """Return how old, s, a scan may get of a laser that gives one each ``period``, s.

    It is a period old when the line has carried it and two when the next one comes, and one may
    be lost; that is LASER.max_age at 38400 baud. A slower laser gets no more than the longest, with
    which the robot stands for every scan lost, and is too old all the time at under 4.5 scans/s.
    """
    limit = (2 + _LOST_SCANS) * period + _SCAN_SLACK
    return min(max(limit, SHORTEST_SCAN_AGE), LONGEST_SCAN_AGE)


CONTROL = FreshnessLimit(
    *("control", "control step in time", 10.0, 0.1),
    "three late within 3 s: the robot stands until they are older than that",
    LogLevel.ERROR,
)
STREAMS = (BASE, LASER, SONAR, POSE)
LIMITS = (*STREAMS, CONTROL)


class FreshnessWatch:
    """Follows when each stream was last well, and tells when that is too long ago."""

    def __init__(self) -> None:
        """Nothing has come yet, and nothing is missed before it has come once."""
        self._well_at: dict[str, float] = {}
        self._missed: set[str] = set()

    def well(self, stream: FreshnessLimit, t: float) -> None:
        """Take note that a stream was well at ``t``, s."""
        self._well_at[stream.name] = t

    def changes(self, t: float) -> list[tuple[FreshnessLimit, bool]]:
        """Return which streams have begun to be missed (False) or have come back (True)."""
        found = []
        for stream in STREAMS:
            well = t - self._well_at.get(stream.name, t) <= stream.max_age
            if well == (stream.name in self._missed):
                found.append((stream, well))
                self._missed ^= {stream.name}
        return found


def markdown() -> str:
    """Return the table for people."""
    lines = ["| Stream | at least, Hz | trusted for, s | then |", "| --- | --- | --- | --- |"]
    lines += [
        f"| {each.what} | {each.rate:g} | {each.max_age:g} | {each.reaction} |" for each in LIMITS
    ]
    return "\n".join(lines)
