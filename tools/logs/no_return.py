"""Which readings of a log mean "no return": loggers write a large number for such a beam.

The number differs with scanner, mode and logger. It is the codes of an LMS 200's measuring mode, or
shows as a pile-up: the log's largest reading occurs far more often than readings just below it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

LASER_REACH = 80.0
"""An LMS measures no farther, m; larger readings are codes."""
_CODES = 9
"""Special values of an LMS 200, the largest numbers its measuring mode can send (SICK telegram
listing 8007954/Q501)."""
_MODES = {f"{reach} m": 1024 * reach - 1 for reach in (8, 16, 32)}
_UNITS = {"mm": 0.001, "cm": 0.01}
_ROUNDING = 0.005
"""Of loggers that write centimetres, m."""
_NEAREST_PILE = 4.0
"""No scanner in use reaches less, m (the shortest at hand, a URG-04LX, 4.095 m): a pile-up nearer
is a wall before a standing robot."""
_LEAST_PILED = 5
_LEAST_SHARE = 0.001  # of all readings
_DENSER = 5.0  # times as many as in a width just below, on average
_WIDTHS_BELOW = 10
_MAX_PILES = 3  # of scanners and loggers together


@dataclass(frozen=True, slots=True)
class NoReturn:
    """Readings, m, from ``limit`` on mean no return."""

    limit: float
    reason: str
    """For people."""


def no_return(readings: Sequence[NDArray[np.float64]], told: float | None = None) -> NoReturn:
    """Return from which reading on those of a log's scans, (n,) m each, mean no return.

    told: the scanner's maximum range by the user or the log, m; None: by the readings alone.
    """
    if told is not None:
        return NoReturn(told, "as told")
    known = np.concatenate(readings) if readings else np.empty(0)
    known = known[np.isfinite(known) & (known > 0.0)]
    found = _by_codes(known) or NoReturn(LASER_REACH, "no scanner's range")
    for _ in range(_MAX_PILES):
        pile = _by_pile(known[known < found.limit], len(known))
        if pile is None:
            break
        found = pile
    return found


def _by_codes(readings: NDArray[np.float64]) -> NoReturn | None:
    """Return the codes of the measuring mode in which the largest of readings (n,) is one."""
    largest = float(readings.max(initial=0.0))
    for unit, metres in _UNITS.items():
        for reach, top in _MODES.items():
            first = metres * (top + 1 - _CODES) - _ROUNDING
            if first <= largest <= metres * top + _ROUNDING:
                return NoReturn(first, f"codes of an LMS 200, {reach} mode in {unit}")
    return None


def _by_pile(readings: NDArray[np.float64], total: int) -> NoReturn | None:
    """Return the pile-up at the largest of readings (n,), of ``total`` in the log; None if none."""
    largest = float(readings.max(initial=0.0))
    if largest < _NEAREST_PILE:
        return None
    width = max(2.0 * _ROUNDING, 5e-4 * largest)
    limit = largest - width
    piled = int(np.count_nonzero(readings >= limit))
    beside = np.count_nonzero(readings >= limit - _WIDTHS_BELOW * width) - piled
    if piled < max(_LEAST_PILED, math.ceil(_LEAST_SHARE * total)):
        return None
    if piled < _DENSER * beside / _WIDTHS_BELOW:
        return None
    return NoReturn(limit, f"{piled} readings pile up there")
