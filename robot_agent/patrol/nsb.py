"""Null-space-based composition of any number of tasks, first the most important (eq. 4, 5)."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from robot_agent.patrol.behaviors import Task

_DEPENDENT = 1e-9  # a Jacobian row this short after projection claims no new direction


def compose(tasks: Sequence[Task], speed_limit: float = math.inf) -> NDArray[np.float64]:
    """Return v = v1 + N1 v2 + N12 v3 + ..., velocity (n,), no faster than speed_limit.

    N12... projects on the null space of the Jacobians of all tasks before, so a task never
    changes the velocity of a more important one. The limit is dealt out in the same order: each
    projected task is scaled to what those before it have left, which keeps its direction.
    """
    velocity = np.zeros_like(tasks[0].velocity)
    null_space = np.eye(len(velocity))
    for task in tasks:
        part = null_space @ task.velocity
        velocity = velocity + _share_within(velocity, part, speed_limit) * part
        null_space = _narrowed(null_space, task.jacobian)
    return velocity


def _share_within(velocity: NDArray[np.float64], part: NDArray[np.float64], limit: float) -> float:
    """Largest share k in 0..1 with norm(velocity + k part) <= limit."""
    a, b, c = float(part @ part), float(velocity @ part), float(velocity @ velocity) - limit**2
    if a == 0.0 or a + 2.0 * b + c <= 0.0:
        return 1.0
    return min(max((-b + math.sqrt(max(b * b - a * c, 0.0))) / a, 0.0), 1.0)


def _narrowed(
    null_space: NDArray[np.float64], jacobian: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Remove the directions of jacobian (m, n) from the projector (n, n)."""
    for row in jacobian:
        free = null_space @ row
        length = math.sqrt(free @ free)
        if length > _DEPENDENT:
            free = free / length
            null_space = null_space - np.outer(free, free)
    return null_space
