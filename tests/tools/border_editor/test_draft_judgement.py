"""Judgement of drafts: the same as of map check, with every stretch that is too near."""

from __future__ import annotations

from pathlib import Path

import pytest

from maps.clearance import NEEDED_CLEARANCE
from maps.map_folder import load_map_folder
from maps.occupancy_map import OccupancyMap
from robot_agent.config import find_map
from tools.border_editor.border_draft import BorderDraft, Vertex, read_draft
from tools.border_editor.draft_judgement import judge
from tools.border_editor.roomy_places import RoomyPlaces

LAB = find_map("paper_lab", Path.cwd())


@pytest.fixture(scope="module")
def occupancy() -> OccupancyMap:
    return load_map_folder(LAB).map


def test_the_shipped_border_is_right(occupancy: OccupancyMap) -> None:
    draft, _ = read_draft(LAB / "border.toml")
    judgement = judge(occupancy, draft, NEEDED_CLEARANCE)
    assert judgement.ok
    assert judgement.length == pytest.approx(51.0, abs=0.01)
    assert judgement.robots == 20
    assert [stretch.ok for stretch in judgement.line] == [True]


def test_half_a_drawing_is_no_error_but_no_border(occupancy: OccupancyMap) -> None:
    judgement = judge(occupancy, BorderDraft(vertices=[Vertex(4, 4)]), NEEDED_CLEARANCE)
    assert not judgement.ok
    assert "needs at least 3" in judgement.error
    assert judgement.line == []


def test_every_stretch_that_is_too_near_is_told(occupancy: OccupancyMap) -> None:
    vertices = [Vertex(4.0, 13.75), Vertex(4.0, 3.2), Vertex(21.1, 3.2), Vertex(21.1, 13.75)]
    judgement = judge(occupancy, BorderDraft(vertices=vertices), NEEDED_CLEARANCE)
    assert not judgement.ok
    assert len([fault for fault in judgement.faults if fault.startswith("s = ")]) >= 2
    assert any("runs through a wall" in fault for fault in judgement.faults)
    assert {stretch.ok for stretch in judgement.line} == {True, False}


def test_a_place_without_room_is_moved_to_the_nearest_with_room(occupancy: OccupancyMap) -> None:
    roomy = RoomyPlaces(occupancy, NEEDED_CLEARANCE)
    assert roomy.nearest(4.0, 8.0) == (4.0, 8.0)
    moved = roomy.nearest(4.9, 8.0)  # in a wall
    assert moved is not None
    assert moved != (4.9, 8.0)
    rows, cols = occupancy.cells_at(moved)
    assert roomy.room[rows[0], cols[0]] >= NEEDED_CLEARANCE
