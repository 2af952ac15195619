"""A robot that stands on the border for good."""

from __future__ import annotations

from typing import NamedTuple


class Wreck(NamedTuple):
    """A robot that stands for good: where, m, its name, and since when, s."""

    x: float
    y: float
    robot: str
    since: float
