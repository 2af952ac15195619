"""Types of arrays over robots: one element per robot, of all runs one after the other."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Reals = NDArray[np.float64]
Flags = NDArray[np.bool_]
Codes = NDArray[np.int8]
"""Small numbers: a direction (+1, -1, 0 for none), an action or a cause by its number."""
Indices = NDArray[np.intp]
