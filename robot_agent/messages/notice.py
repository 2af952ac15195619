"""Log messages of the agent's parts for people."""

from __future__ import annotations

from dataclasses import dataclass

from robot_agent.messages.log_level import LogLevel


@dataclass(frozen=True, slots=True)
class Notice:
    """A message of one part of the agent; published only if it differs from that part's last."""

    t: float
    part: str
    words: str
    level: LogLevel
