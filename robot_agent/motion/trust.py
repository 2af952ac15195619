"""What the agent depends on: how often it comes, how old it may get, what happens when it does.

This table is the only place of these figures: the gate's limits, the alarms and the README's table
come from it.
"""

from __future__ import annotations

from dataclasses import dataclass

from robot_agent.foxglove import LogLevel


@dataclass(frozen=True, slots=True)
class Trusted:
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


BASE = Trusted("base", "base report", 10.0, 0.3, "robot stands", LogLevel.ERROR)
LASER = Trusted("laser", "laser scan", 5.0, 0.4, "robot stands", LogLevel.ERROR)
POSE = Trusted(
    "localization", "localized pose", 5.0, 10.0, "slow; lost: stands, then turns", LogLevel.WARNING
)
SONAR = Trusted("sonar", "sonar echo", 3.0, 0.5, "echo is forgotten", LogLevel.WARNING)
CONTROL = Trusted(
    "control", "control step", 10.0, 0.1, "late 3 times: robot stands", LogLevel.ERROR
)
TRUSTED = (BASE, LASER, SONAR, POSE, CONTROL)
