"""A robot stopped permanently on the border."""

from __future__ import annotations

from typing import NamedTuple


class Wreck(NamedTuple):
    """A robot stopped permanently: position, m, map frame, name, and time since which it stands."""

    x: float
    y: float
    robot: str
    since: float
