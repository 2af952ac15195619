"""Shortest paths over a grid: SciPy's Dijkstra finds the same lengths."""

import itertools
import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from maps.approach_field import TWO_WHEELED_PIONEER, _cell_costs, _clearances
from maps.map_folder import load_map_folder
from maps.shortest_paths import NOWHERE, shortest_paths

MAPS = Path(__file__).parents[2] / "maps"
STEPS = [
    (row, col) for row, col in itertools.product(range(-2, 3), repeat=2) if math.gcd(row, col) == 1
]


def dijkstra_of_scipy(cost, goals) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """The same by the reference: lengths, and the node before each."""
    rows, cols = cost.shape
    cells = np.arange(cost.size).reshape(cost.shape)
    ones, others, lengths = [], [], []
    for row, col in STEPS:
        here = (slice(max(-row, 0), rows - max(row, 0)), slice(max(-col, 0), cols - max(col, 0)))
        there = (slice(max(row, 0), rows + min(row, 0)), slice(max(col, 0), cols + min(col, 0)))
        length = (cost[here] + cost[there]) / 2.0 * math.hypot(row, col)
        joined = np.isfinite(length)
        ones.append(cells[here][joined])
        others.append(cells[there][joined])
        lengths.append(length[joined])
    edges = (np.concatenate(lengths), (np.concatenate(ones), np.concatenate(others)))
    graph = coo_array(edges, shape=(cost.size, cost.size)).tocsr()
    starts = np.flatnonzero(goals & np.isfinite(cost))
    found, before, _ = dijkstra(graph, indices=starts, min_only=True, return_predecessors=True)
    before = np.where(before < 0, NOWHERE, before)
    return found.reshape(cost.shape).astype(np.float32), before.reshape(cost.shape)


@pytest.mark.parametrize("name", ["paper_lab", "intel_lab", "large_hall"])
def test_shipped_maps_have_the_paths_of_scipy(name):
    folder = load_map_folder(MAPS / name)
    assert folder.border is not None
    clearance = _clearances(folder.map)
    rows, cols = folder.map.cells_at(folder.border.polyline(folder.map.resolution / 2))
    goals = np.zeros(clearance.shape, dtype=np.bool_)
    goals[rows, cols] = True
    cost = _cell_costs(clearance, goals, TWO_WHEELED_PIONEER)
    lengths, next_cell = shortest_paths(cost, goals)
    expected, before = dijkstra_of_scipy(cost, goals)
    assert np.array_equal(lengths, expected)
    assert np.mean(next_cell != before) < 0.01  # of equal paths either is right


@pytest.mark.parametrize("seed", range(8))
def test_random_grids_have_the_lengths_of_scipy(seed):
    rng = np.random.default_rng(seed)
    shape = tuple(rng.integers(1, 40, size=2))
    cost = rng.choice((1.0, 1.7, 3.0, np.inf), size=shape)
    goals = rng.random(shape) < 0.02
    lengths, next_cell = shortest_paths(cost, goals)
    if not (goals & np.isfinite(cost)).any():
        assert np.isinf(lengths).all()
        assert (next_cell == NOWHERE).all()
        return
    expected, _ = dijkstra_of_scipy(cost, goals)
    assert np.array_equal(lengths, expected)


def test_each_next_cell_is_one_step_nearer():
    rng = np.random.default_rng(3)
    cost = rng.choice((1.0, 3.0, np.inf), size=(30, 40))
    goals = np.zeros(cost.shape, dtype=np.bool_)
    cost[5, 7], goals[5, 7] = 1.0, True
    lengths, next_cell = shortest_paths(cost, goals)
    assert next_cell[5, 7] == NOWHERE
    for cell in np.flatnonzero(next_cell != NOWHERE).tolist():
        there = int(next_cell.flat[cell])
        (row, col), (to_row, to_col) = divmod(cell, 40), divmod(there, 40)
        assert (to_row - row, to_col - col) in STEPS
        step = (cost.flat[cell] + cost.flat[there]) / 2.0 * math.hypot(to_row - row, to_col - col)
        assert lengths.flat[cell] == pytest.approx(lengths.flat[there] + step, rel=1e-6)
