"""Maps drawn from floor plans."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from maps.occupancy_map import FREE, OCCUPIED, UNKNOWN, MapError, load_map
from tools.mapping.floor_plan import draw_floor_plan

MAPS = Path(__file__).resolve().parents[3] / "maps"
PLAN = """
resolution = 0.1
origin = [-1.0, -1.0]
size = [6.0, 5.0]
wall_thickness = 0.2
floor = [[0, 0], [4, 0], [4, 3], [0, 3]]
[[wall]]
points = [[0, 0], [4, 0], [4, 3], [0, 3], [0, 0]]
[[door]]
from = [1.0, 0.0]
to = [2.0, 0.0]
[[box]]
center = [3.0, 2.0]
size = [1.0, 0.2]
angle = 90.0
[[pillar]]
center = [1.0, 2.0]
radius = 0.3
"""


def test_each_shape_is_drawn_at_its_place(tmp_path: Path) -> None:
    plan = tmp_path / "plan.toml"
    plan.write_text(PLAN)
    occupancy = draw_floor_plan(plan, tmp_path / "drawn")
    assert occupancy.cells.shape == (50, 60)

    def state(x: float, y: float) -> int:
        (row,), (col,) = occupancy.cells_at([(x, y)])
        return int(occupancy.cells[row, col])

    assert state(-0.5, 1.0) == UNKNOWN
    assert state(0.5, 1.0) == FREE
    assert state(2.55, 0.05) == OCCUPIED  # wall
    assert state(1.55, 0.05) == FREE  # door
    assert state(0.95, 0.05) == OCCUPIED  # beside it
    assert state(3.05, 2.45) == OCCUPIED  # the turned box stands upright
    assert state(3.45, 2.05) == FREE
    assert state(1.25, 2.05) == OCCUPIED  # pillar
    assert state(1.35, 2.05) == FREE


@pytest.mark.parametrize("shipped", ["paper_lab", "large_hall"])
def test_shipped_maps_are_drawn_from_their_plans(shipped: str, tmp_path: Path) -> None:
    draw_floor_plan(MAPS / shipped / "floor_plan.toml", tmp_path)
    for name in ("map.yaml", "map.pgm"):
        assert (tmp_path / name).read_bytes() == (MAPS / shipped / name).read_bytes()
    assert np.isin([FREE, OCCUPIED, UNKNOWN], load_map(tmp_path / "map.yaml").cells).all()


@pytest.mark.parametrize(
    ("text", "word"),
    [
        (PLAN.replace("[[pillar]]", "[[column]]"), "column"),
        (PLAN.replace("radius = 0.3", "radius = -0.3"), "radius"),
        (PLAN.replace("wall_thickness = 0.2", ""), "wall_thickness"),
        ("resolution = [", "plan.toml"),
    ],
)
def test_a_bad_plan_is_a_map_error_naming_it(tmp_path: Path, text: str, word: str) -> None:
    plan = tmp_path / "plan.toml"
    plan.write_text(text)
    with pytest.raises(MapError, match=word) as caught:
        draw_floor_plan(plan, tmp_path)
    assert str(plan) in str(caught.value)


def test_a_missing_plan_is_a_map_error(tmp_path: Path) -> None:
    with pytest.raises(MapError, match="cannot read the floor plan"):
        draw_floor_plan(tmp_path / "none.toml", tmp_path)
