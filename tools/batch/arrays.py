"""Types of arrays over robots: one element per robot, of all runs one after the other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Reals = NDArray[np.float64]
Flags = NDArray[np.bool_]
Codes = NDArray[np.int8]
"""Small numbers: a direction (+1, -1, 0 for none), an action or a cause by its number."""
Indices = NDArray[np.intp]


def pick(holder: object, names: Sequence[str], robots: Indices) -> None:
    """Keep some robots in the arrays of a holder, whose last axis is over robots.

    robots: their numbers, in the order to come; one may come several times.
    """
    for name in names:
        setattr(holder, name, getattr(holder, name)[..., robots])
