"""How far a robot goes until it stands, and how fast it may be to stand in time."""

from __future__ import annotations

import math


def stopping_way(rate: float, braking: float, delay: float) -> float:
    """Way (or angle) until standstill from a rate, after a delay."""
    return rate * rate / (2.0 * braking) + rate * delay


def stoppable_rate(way: float, braking: float, delay: float) -> float:
    """Largest rate from which the robot stops within a way: the inverse of stopping_way."""
    return braking * (math.sqrt(delay * delay + 2.0 * way / braking) - delay)
