"""``patrol map show``: zones in the picture and in words."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from maps.map_folder import load_map_folder
from maps.zone import Zone
from robot_agent.config import find_map
from tools.cli import main
from tools.mapping.map_picture import render_map
from tools.mapping.zone_stretches import zone_lines

FOLDER = load_map_folder(find_map("paper_lab", Path()))
WEST = Zone("west half", ((0.0, 0.0), (12.0, 0.0), (12.0, 18.0), (0.0, 18.0)))
FAR = Zone("far room", ((24.0, 16.0), (24.5, 16.0), (24.5, 17.0)))


def test_zone_is_drawn_along_its_outline() -> None:
    plain, drawn = render_map(FOLDER), render_map(FOLDER, zones=[WEST])
    changed = (plain != drawn).any(axis=2)
    cols = np.nonzero(changed)[1]
    assert np.count_nonzero(cols == cols.max()) > 0.3 * changed.shape[0], "its east side"
    assert changed.mean() < 0.02


def test_stretches_of_the_border_are_told_by_zone() -> None:
    first, second = zone_lines([WEST, FAR], FOLDER.border)
    assert first == "west half: s = 0.0 to 6.8 m and s = 32.8 to 51.0 m"
    assert second == "far room: none of the border"
    assert zone_lines([WEST], None) == ["west half: none of the border"]


def test_command_lists_the_zones(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["map", "show", "paper_lab", "-o", str(tmp_path / "map.png")]) == 0
    told = capsys.readouterr().out.splitlines()
    assert told[0] == str(tmp_path / "map.png")
    assert told[1].startswith("west corridor: s = ")
    assert len(told) == 9
    assert cv2.imread(str(tmp_path / "map.png")) is not None


def test_map_without_zones_lists_none(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["map", "show", "intel_lab", "-o", str(tmp_path / "map.png")]) == 0
    assert capsys.readouterr().out.splitlines() == [str(tmp_path / "map.png")]


def test_caption_needs_no_zones() -> None:
    assert render_map(replace(FOLDER, border=None), zones=[FAR]).shape[2] == 3
