"""What a part of the agent has to say to people."""

from __future__ import annotations

from dataclasses import dataclass

from robot_agent.messages.log_level import LogLevel


@dataclass(frozen=True, slots=True)
class Notice:
    """A message of one part of the agent; published only if that part last said something else."""

    t: float
    part: str
    words: str
    level: LogLevel
