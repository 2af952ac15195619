"""Loops suggested on the shipped maps and on maps without one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from maps.clearance import NEEDED_CLEARANCE
from maps.map_folder import load_map_folder
from maps.occupancy_map import FREE, OCCUPIED, OccupancyMap
from maps.pose import Pose
from robot_agent.config import find_map
from tools.border_editor.draft_judgement import judge
from tools.border_editor.suggested_loop import suggest_loop


@pytest.mark.parametrize(
    ("name", "drawn_m"), [("paper_lab", 51.0), ("intel_lab", 70.0), ("large_hall", 217.0)]
)
def test_loop_of_a_shipped_map_is_a_border_about_as_long_as_the_drawn_one(
    name: str, drawn_m: float
) -> None:
    occupancy = load_map_folder(find_map(name, Path.cwd())).map
    draft = suggest_loop(occupancy, NEEDED_CLEARANCE)
    assert draft is not None
    judgement = judge(occupancy, draft, NEEDED_CLEARANCE)
    assert judgement.ok
    assert judgement.length == pytest.approx(drawn_m, rel=0.1)


def test_a_room_without_anything_to_go_round_has_none() -> None:
    cells = np.full((100, 100), OCCUPIED, dtype=np.uint8)
    cells[10:90, 10:90] = FREE
    assert suggest_loop(OccupancyMap(cells, 0.05, Pose(0.0, 0.0, 0.0)), NEEDED_CLEARANCE) is None
    cells[:] = OCCUPIED
    assert suggest_loop(OccupancyMap(cells, 0.05, Pose(0.0, 0.0, 0.0)), NEEDED_CLEARANCE) is None
