"""A fixed piece of work that measures the processor: speeds are judged as multiples of it.

Made like the product's own work: Python numbers, small arrays, large arrays. Two machines, or one
at two loads, need different times for it, and for everything else in about the same proportion.
"""

from __future__ import annotations

import math
import time

import numpy as np

REFERENCE_S = 0.0206
"""Processor time, s, of the kernel where the limits of the figures were set: the core of the table
in tools/bench/README.md. Not measured there: a core that needs 0.033 s ran the three benches of
that table 1.59 to 1.62 times slower."""
_PASSES = 5


def kernel_s() -> float:
    """Return the processor time of the kernel now, s: the median of five passes."""
    times = []
    for _ in range(_PASSES):
        started = time.process_time()
        _work()
        times.append(time.process_time() - started)
    return float(np.median(times))


def _work() -> float:
    rng = np.random.default_rng(1)
    small, large = rng.random(60), rng.random(20000)
    total = _python_numbers(80000)
    for _ in range(10000):
        total += float(np.maximum(small * 1.5 - 0.2, 0.0)[7])
    for _ in range(240):
        total += float(np.sqrt(large * large + 1.0).max())
    return total


def _python_numbers(count: int) -> float:
    x, y, turn = 0.0, 0.0, {1: 0.3, -1: 0.2}
    for index in range(count):
        heading = 0.01 * index
        x, y = _ahead(x, y, heading, turn[1 if index % 3 else -1])
    return math.hypot(x, y)


def _ahead(x: float, y: float, heading: float, step: float) -> tuple[float, float]:
    return x + step * math.cos(heading), y + step * math.sin(heading)
