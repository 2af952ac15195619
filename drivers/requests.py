"""What a device session asks of its link; the owner of the link carries it out in order."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Write:
    """Send these bytes."""

    data: bytes


@dataclass(frozen=True, slots=True)
class SetBaud:
    """Change the local port's rate once all earlier writes have left; discards unread input."""

    baud: int


Request = Write | SetBaud
