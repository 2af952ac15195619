"""Shortest paths over a grid from every cell to the nearest goal.

Dijkstra's algorithm, a wave at a time: no step is shorter than a cell, so all cells whose distance
is within one cell of the nearest unfinished one are finished together, by operations on arrays.
The lengths are those of SciPy's Dijkstra to the last bit; SciPy would cost an agent 25 MB and
0.13 s for this alone, and as much again for the graph's matrix.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

NOWHERE = -1
"""Index of no cell."""

_HALF = ((0, 1), (1, 0), (1, 1), (1, -1), (1, 2), (2, 1), (2, -1), (1, -2))
_STEPS = np.array([*_HALF, *((-row, -col) for row, col in _HALF)])
"""(16, 2) rows and columns to neighboring cells; 16 directions keep lengths within 3 %."""
_LENGTHS = np.array([math.hypot(row, col) for row, col in _STEPS.tolist()])
_RIM = 2  # cells of the longest step, so that no step leaves the padded grid


def shortest_paths(
    cost: NDArray[np.float64], goals: NDArray[np.bool_]
) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Return (rows, cols) path lengths in cells to the nearest goal, and each path's next cell.

    cost: (rows, cols) factor of each cell's length, at least 1, infinite where no path leads; a
    step costs the mean of its two ends. goals: (rows, cols), counted where the cost is finite.
    Length infinite and next cell NOWHERE where there is no path; NOWHERE at the goals too.
    """
    width = cost.shape[1] + 2 * _RIM
    factor = np.pad(cost, _RIM, constant_values=np.inf).ravel()
    reach = _STEPS @ np.array((width, 1))
    length = np.full(factor.size, np.inf)
    before = np.full(factor.size, NOWHERE)
    wave = np.flatnonzero(np.pad(goals, _RIM).ravel() & np.isfinite(factor))
    length[wave] = 0.0
    waiting = wave[:0]
    finished = 0.0
    while len(wave) or len(waiting):
        reached = _relax(wave, reach, factor, length, before)
        waiting = np.concatenate((waiting, reached))
        finished += 1.0
        distance = length[waiting]
        near = distance < finished + 1.0
        wave = _once_each(waiting[near & (distance >= finished)])
        waiting = waiting[~near]
    inner = (slice(_RIM, -_RIM), slice(_RIM, -_RIM))
    row, col = np.divmod(before.reshape(-1, width)[inner], width)
    next_cell = np.where(row < 0, NOWHERE, (row - _RIM) * cost.shape[1] + col - _RIM)
    return length.reshape(-1, width)[inner].astype(np.float32), next_cell.astype(np.int32)


def _once_each(cells: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return cells sorted and without repetitions; ``np.unique`` would import all of ``np.ma``."""
    ordered = np.sort(cells)
    first = np.ones(len(ordered), dtype=np.bool_)
    np.not_equal(ordered[1:], ordered[:-1], out=first[1:])
    return ordered[first]


def _relax(
    wave: NDArray[np.intp],
    reach: NDArray[np.intp],
    factor: NDArray[np.float64],
    length: NDArray[np.float64],
    before: NDArray[np.intp],
) -> NDArray[np.intp]:
    """Shorten the paths of a wave's neighbors in place; return those that became shorter.

    Of equal paths the one through the cell nearest to its goal is taken, as by Dijkstra.
    """
    wave = wave[np.argsort(-length[wave], kind="stable")]
    there = wave[:, None] + reach
    step = (factor[wave][:, None] + factor[there]) / 2.0 * _LENGTHS
    total = (step + length[wave][:, None]).ravel()
    there = there.ravel()
    shorter = np.flatnonzero(total < length[there])
    there, total = there[shorter], total[shorter]
    np.minimum.at(length, there, total)
    best = np.flatnonzero(total == length[there])
    before[there[best]] = wave[shorter[best] // len(reach)]  # the last of equals stays
    return there[best]
