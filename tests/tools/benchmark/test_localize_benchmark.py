"""The localizer's benchmark: complete table, scans on the map, memory of a large map in limits."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from maps.map_folder import load_map_folder
from robot_agent.config import find_map
from tools.benchmark import localize_benchmark
from tools.benchmark.localize_benchmark import (
    BEAMS,
    PARTICLES,
    large_map_cost,
    scans_along,
    update_costs,
)


def test_costs_cover_every_number_of_particles_and_beams(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(localize_benchmark, "UPDATES", 8)
    costs = list(update_costs(find_map("intel_lab", Path.cwd())))
    assert {(c.particles, c.beams) for c in costs} == {(p, b) for p in PARTICLES for b in BEAMS}
    for cost in costs:
        assert cost.filter_ms > 0.0
        assert cost.products_per_s == pytest.approx(
            cost.particles * cost.beams / (cost.filter_ms / 1e3)
        )


def test_scans_lie_on_the_map() -> None:
    folder = load_map_folder(find_map("intel_lab", Path.cwd()))
    assert folder.border is not None
    distance = folder.map.distance_field()
    scans = scans_along(folder.map, folder.border.polyline(1.0)[:10])
    assert len(scans) == 9
    for pose, points in scans:
        c, s = np.cos(pose.theta), np.sin(pose.theta)
        ends = points @ np.array(((c, s), (-s, c))) + pose[:2]
        rows, cols = folder.map.cells_at(ends)
        assert np.median(distance[rows, cols]) <= folder.map.resolution


def test_a_localizer_keeps_less_than_4_bytes_a_cell_of_a_large_map_and_needs_less_than_8() -> None:
    cost = large_map_cost(4000)
    assert cost.kept < 4.0
    assert cost.peak < 8.0
    assert cost.start_s > 0.0
    assert cost.search_ms > 0.0
