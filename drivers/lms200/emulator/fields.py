"""The monitored fields A, B and C of an emulated LMS 200: kept, read back and evaluated.

A field's content is returned as it was written. The listing's coordinates are known to us by their
purpose only, so the layout is ours: a shape byte, then words in the configured unit: of a rectangle
its extent right, left and ahead, of a radial field the radii of equal sectors from right to left.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

FIELDS_IN_SET = 3
FIELD_NUMBERS = range(1, 2 * FIELDS_IN_SET + 1)  # A, B, C of set 1, then of set 2
FIELD_SETS = (1, 2)
UNUSED, RECTANGLE, RADIAL = range(3)
TAUGHT_SECTORS = 181
TAUGHT_GAP = 0.1  # m by which a taught field stays clear of what was seen; ours

_METRES = {0: 0.01, 1: 0.001}  # by the configuration's units
_LONGEST = 1 + 2 * 401


@dataclass(slots=True)
class MonitoredFields:
    """Contents by field number, the active set, and evaluations in a row that found each infringed.

    ``infringed_scans`` holds those of fields A, B, C of the active set.
    """

    stored: dict[int, bytes] = field(default_factory=dict)
    active_set: int = 1
    infringed_scans: list[int] = field(default_factory=lambda: [0] * FIELDS_IN_SET)

    def write(self, number: int, content: bytes) -> bool:
        """Keep a field's content; returns False, and keeps nothing, where it is none."""
        if number not in FIELD_NUMBERS or not is_field(content):
            return False
        self.stored[number] = content
        return True

    def read(self, number: int) -> bytes | None:
        """Return a field's content, an unused one where none was written; None: no such field."""
        return self.stored.get(number, bytes((UNUSED,))) if number in FIELD_NUMBERS else None

    def teach(
        self, number: int, ranges: NDArray[np.float64], degrees: NDArray[np.float64], units: int
    ) -> None:
        """Make a radial field of what was seen: ranges (n,) m at (n,) degrees, 0 right."""
        sectors = np.linspace(0.0, 180.0, TAUGHT_SECTORS)
        radii = np.interp(sectors, degrees, np.nan_to_num(ranges, posinf=8.0)) - TAUGHT_GAP
        words = np.clip(np.rint(radii / _METRES[units]), 0, 0xFFFF).astype("<u2")
        self.stored[number] = bytes((RADIAL,)) + words.tobytes()

    def beams_inside(
        self, ranges: NDArray[np.float64], degrees: NDArray[np.float64], units: int
    ) -> list[NDArray[np.bool_]]:
        """Return for A, B and C of the active set which beams (n,) end inside the field."""
        first = FIELD_NUMBERS[0] + FIELDS_IN_SET * (self.active_set - 1)
        return [
            _inside(self.stored.get(number, b"\0"), ranges, degrees, _METRES[units])
            for number in range(first, first + FIELDS_IN_SET)
        ]

    def evaluate(
        self, ranges: NDArray[np.float64], degrees: NDArray[np.float64], units: int
    ) -> None:
        """Count the scan for each field that it infringes."""
        found = self.beams_inside(ranges, degrees, units)
        self.infringed_scans = [
            scans + 1 if inside.any() else 0
            for scans, inside in zip(self.infringed_scans, found, strict=True)
        ]

    def infringed(self, evaluations: int) -> list[bool]:
        """Return for A, B and C whether it was infringed in so many scans in a row."""
        return [scans >= max(evaluations, 1) for scans in self.infringed_scans]


def is_field(content: bytes) -> bool:
    """Return whether bytes are a field's content."""
    if not content or len(content) > _LONGEST or len(content) % 2 != 1:
        return False
    shape, words = content[0], len(content) // 2
    return {UNUSED: words == 0, RECTANGLE: words == 3, RADIAL: words > 1}.get(shape, False)


def _inside(
    content: bytes, ranges: NDArray[np.float64], degrees: NDArray[np.float64], metres: float
) -> NDArray[np.bool_]:
    inside = np.zeros(ranges.shape, dtype=np.bool_)
    words = np.frombuffer(content, "<u2", offset=1) * metres
    if content[0] == RADIAL:
        sectors = np.rint(degrees / 180.0 * (words.size - 1)).astype(int)
        inside = ranges < words[np.clip(sectors, 0, words.size - 1)]
    elif content[0] == RECTANGLE:
        right, left, ahead = words
        seen = np.isfinite(ranges)
        across = ranges[seen] * np.cos(np.radians(degrees[seen]))
        along = ranges[seen] * np.sin(np.radians(degrees[seen]))
        inside[seen] = (across <= right) & (-across <= left) & (along <= ahead)
    return inside
