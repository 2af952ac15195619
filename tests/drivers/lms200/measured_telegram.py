"""A B0 telegram made of ranges."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drivers.lms200.measurement import MeasuringMode, count_word, encode_ranges
from drivers.lms200.telegrams import MEASURED_VALUES, STATUS_OK


def encode_measurement(
    ranges: NDArray[np.float64],
    mode: MeasuringMode,
    units: int,
    *,
    reflectors: NDArray[np.bool_] | None = None,
) -> bytes:
    """Return the payload for ranges (n,), m, of a healthy laser."""
    values = encode_ranges(ranges, mode, units, reflectors)
    head = bytes((MEASURED_VALUES,)) + count_word(ranges.size, units)
    return head + values.tobytes() + bytes((STATUS_OK,))
