"""Lines of a machine's journal, and what they say of the agent."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

AGENT = "patrol-"
"""Begin of the identifier of the agent's own lines; others about its unit are systemd's."""


@dataclass(frozen=True, slots=True)
class JournalLine:
    """One line; t: s since the kernel's start."""

    t: float
    source: str
    text: str

    @classmethod
    def of(cls, fields: Mapping[str, object]) -> JournalLine:
        """Return a line from journalctl's JSON."""
        return cls(
            float(str(fields["__MONOTONIC_TIMESTAMP"])) / 1e6,
            str(fields.get("SYSLOG_IDENTIFIER", "")),
            str(fields.get("MESSAGE", "")),
        )

    @property
    def by_agent(self) -> bool:
        """Whether the agent wrote it."""
        return self.source.startswith(AGENT)


def first_time(lines: Sequence[JournalLine], words: str, since: float = 0.0) -> float | None:
    """Return the time of the first line since then that contains the words, None if none does."""
    return next((line.t for line in lines if line.t >= since and words in line.text), None)


def says(lines: Sequence[JournalLine], words: str) -> bool:
    """Return whether a line contains the words."""
    return first_time(lines, words) is not None


def starts(lines: Sequence[JournalLine]) -> int:
    """Return how many times systemd has begun to start the service."""
    return sum(not line.by_agent and line.text.startswith("Starting ") for line in lines)


def lines_an_hour(lines: Sequence[JournalLine], since: float, until: float) -> float:
    """Return the rate of lines of a stretch of time; both times in s since the kernel's start."""
    return sum(since <= line.t < until for line in lines) / (until - since) * 3600.0
