"""Figures of the localization."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from robot_agent.config import find_map
from tools.benchmark.figure import Figure
from tools.benchmark.localize_benchmark import large_map_cost, update_costs


def localization(_folder_path: Path) -> Iterator[Figure]:
    """Time the localizer for several numbers of particles and beams on the map of a building."""
    limits = {(2000, 60): 0.9, (5000, 180): 4.0}
    for cost in update_costs(find_map("intel_lab", Path.cwd())):
        size = f"localization, {cost.particles} particles x {cost.beams} beams"
        limit = limits.get((cost.particles, cost.beams))
        yield Figure(f"{size}, filter", cost.filter_ms, "ms", limit, speed=True)
        yield Figure(f"{size}, with refinement and check", cost.whole_ms, "ms", speed=True)
        yield Figure(f"{size}, products", 1e-6 * cost.products_per_s, "million/s", speed=True)
    large = large_map_cost()
    of_map = "localization, map of 23 million cells"
    yield Figure(f"{of_map}, kept", large.kept, "bytes/cell", 4.0)
    yield Figure(f"{of_map}, peak", large.peak, "bytes/cell", 8.0)
    yield Figure(f"{of_map}, start", large.start_s, "s", 1.0, speed=True)
    longest = f"{of_map}, search of all of it, longest scan"
    yield Figure(longest, large.search_ms, "ms", 100.0, speed=True)
