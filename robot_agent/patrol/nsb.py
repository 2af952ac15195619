"""Null-space-based composition of any number of tasks, by descending priority (eq. 4, 5).

Computed in plain Python numbers: for two or three dimensions several times faster than arrays. The
usual case of two is written out, with bit-identical results.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from operator import mul

from robot_agent.patrol.behaviors import Task

DEPENDENT = 1e-9  # a Jacobian row this short after projection claims no new direction

Numbers = Sequence[float]


def compose(tasks: Sequence[Task], speed_limit: float = math.inf) -> tuple[float, ...]:
    """Return v = v1 + N1 v2 + N12 v3 + ..., n components, no faster than speed_limit.

    tasks: by descending priority; velocities of n components each, m/s. N12... projects on the
    null space of the Jacobians of all tasks before, so a task never changes the velocity of one of
    higher priority. speed_limit, m/s, is allotted in the same order: each projected task is scaled
    to what those before it leave, which keeps its direction.
    """
    velocity: Numbers = (0.0,) * len(tasks[0].velocity)
    claimed: list[Numbers] = []  # directions of the tasks so far, orthonormal
    last = tasks[-1]
    for task in tasks:
        part = _projected(task.velocity, claimed) if claimed else task.velocity
        if any(part):
            share = _share_within(velocity, part, speed_limit)
            velocity = _sum(velocity, share, part)
        if task is not last:
            _claim(task.jacobian, claimed)
    return tuple(velocity)


def _dot(a: Numbers, b: Numbers) -> float:
    if len(a) == 2:
        return a[0] * b[0] + a[1] * b[1]
    return math.fsum(map(mul, a, b))


def _sum(a: Numbers, factor: float, b: Numbers) -> Numbers:
    """Return a + factor b."""
    if len(a) == 2:
        return a[0] + factor * b[0], a[1] + factor * b[1]
    return [x + factor * y for x, y in zip(a, b, strict=True)]


def _divided(a: Numbers, divisor: float) -> Numbers:
    if len(a) == 2:
        return a[0] / divisor, a[1] / divisor
    return [x / divisor for x in a]


def _projected(vector: Numbers, claimed: Sequence[Numbers]) -> Numbers:
    """Return the component of a vector orthogonal to all claimed directions (orthonormal)."""
    for direction in claimed:
        vector = _sum(vector, -_dot(vector, direction), direction)
    return vector


def _share_within(velocity: Numbers, part: Numbers, limit: float) -> float:
    """Return the largest share k in 0..1 with norm(velocity + k part) <= limit."""
    a = _dot(part, part)
    if a == 0.0:  # the square underflows
        return 1.0
    b, c = _dot(velocity, part), _dot(velocity, velocity) - limit**2
    if a + 2.0 * b + c <= 0.0:
        return 1.0
    return min(max((-b + math.sqrt(max(b * b - a * c, 0.0))) / a, 0.0), 1.0)


def _claim(jacobian: Sequence[Numbers], claimed: list[Numbers]) -> None:
    """Add the directions of a Jacobian's rows to those claimed."""
    for row in jacobian:
        free = _projected(row, claimed)
        length = math.sqrt(_dot(free, free))
        if length > DEPENDENT:
            # Project again: the division scales up the rounding error along claimed directions.
            free = _projected(_divided(free, length), claimed)
            claimed.append(_divided(free, math.sqrt(_dot(free, free))))
