"""Severity of log messages; the numbers are those of foxglove.Log."""

from __future__ import annotations

from enum import IntEnum


class LogLevel(IntEnum):
    """Severity of a ``foxglove.Log``."""

    DEBUG = 1
    INFO = 2
    WARNING = 3
    ERROR = 4
    FATAL = 5
