"""Stopping way for a speed, and the speed for a stopping way."""

from __future__ import annotations

import math


def stopping_way(rate: float, braking: float, delay: float) -> float:
    """Return the way (m or rad) from a rate (per s) to standstill.

    braking: deceleration (per s2), after a delay, s.
    """
    return rate * rate / (2.0 * braking) + rate * delay


def stoppable_rate(way: float, braking: float, delay: float) -> float:
    """Return the largest rate from which the robot stops within a way; inverse of stopping_way."""
    return braking * (math.sqrt(delay * delay + 2.0 * way / braking) - delay)
