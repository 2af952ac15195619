"""Figures of the localization."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from robot_agent.config import find_map
from tools.benchmark.figure import Figure
from tools.benchmark.localize_benchmark import large_map_mb, update_costs


def localization(_folder_path: Path) -> Iterator[Figure]:
    """Time the localizer for several numbers of particles and beams on the map of a building."""
    limits = {(2000, 60): 0.9, (5000, 180): 4.0}
    for cost in update_costs(find_map("intel_lab", Path.cwd())):
        size = f"localization, {cost.particles} particles x {cost.beams} beams"
        limit = limits.get((cost.particles, cost.beams))
        yield Figure(f"{size}, filter", cost.filter_ms, "ms", limit, speed=True)
        yield Figure(f"{size}, with refinement and check", cost.whole_ms, "ms", speed=True)
        yield Figure(f"{size}, products", 1e-6 * cost.products_per_s, "million/s", speed=True)
    yield Figure("localization, map of 100 x 100 m at 0.05 m", large_map_mb(), "MB", 60.0)
