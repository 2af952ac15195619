"""Walls of the map near the robot that are there no longer: the laser has seen through them.

While such a place is in view, the scan counts and not the map. Out of view the map's wall would
be back: a robot that turns in a doorway which the map shows closed would be pinned for good.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

ASIDE = 0.10
"""m to each side that must be seen through too: the error of the pose beside a door frame. Ours."""
_BEYOND = 0.25  # m that beams go on behind the place, ours: more than a wall's thickness in error
_THERE = 0.10  # m; a return so near to a wall's place comes from it
_HEARD = 0.25  # m between an echo and a wall's place: lasers see through glass, sonars hear it
_GONE, _SURE = 3, 20  # scans seen through from which it is gone, and at most counted
_HEARD_COST = 2  # of those scans, for each in which an echo is near


class GoneWalls:
    """Counts, for cells of the map near the robot, the scans that have seen through them."""

    def __init__(self) -> None:
        """Start without evidence: all walls are there."""
        self._cells = np.empty(0, dtype=np.intp)  # ascending
        self._scans = np.empty(0, dtype=np.intp)  # of each of these cells

    @property
    def cells(self) -> NDArray[np.intp]:
        """The flat indices (n,) of the cells near the robot whose wall is gone."""
        return self._cells[self._scans >= _GONE]

    def update(
        self,
        cells: NDArray[np.intp],
        places: NDArray[np.float64],
        beyond: tuple[NDArray[np.float64], NDArray[np.float64]],
        echoes: NDArray[np.float64],
    ) -> None:
        """Take in one scan; cells that are no longer among those near are forgotten.

        cells: flat indices (n,), ascending, of the map's walls near the robot; places: (n, 2), m,
        base_link, the nearest point of each. beyond: (n,), m, how far the beam to each goes beyond
        it, and how far all beams within ``ASIDE`` of it do, -inf where none tells. echoes: (m, 2),
        m, base_link, those of sonars.
        """
        scans = np.zeros(len(cells), dtype=np.intp)
        known = np.isin(cells, self._cells, assume_unique=True)
        scans[known] = self._scans[np.searchsorted(self._cells, cells[known])]
        at, aside = beyond
        scans[aside > _BEYOND] += 1
        scans[np.abs(at) < _THERE] = 0
        if len(echoes):
            away = np.hypot(*(places[:, None] - echoes).transpose(2, 0, 1))
            scans[(away < _HEARD).any(axis=1)] -= _HEARD_COST
        np.clip(scans, 0, _SURE, out=scans)
        self._cells, self._scans = cells[scans > 0], scans[scans > 0]

    def forget(self) -> None:
        """Drop all evidence, as when the robot may have been carried."""
        self._cells, self._scans = self._cells[:0], self._scans[:0]
