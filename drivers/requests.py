"""Requests of a device session to its link; the link's owner executes them in order."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Write:
    """Send bytes."""

    data: bytes


@dataclass(frozen=True, slots=True)
class SetBaud:
    """Change the local port's rate once all earlier writes have left; discards unread input."""

    baud: int


Request = Write | SetBaud
