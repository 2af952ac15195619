"""What ``patrol map check`` says of zones."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from maps.zone_file import ZONES_FILE
from robot_agent.config import find_map
from tools.mapping.map_check import check_map


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    shutil.copytree(find_map("paper_lab", Path()), tmp_path / "lab")
    return tmp_path / "lab"


def zone_lines(folder: Path) -> list[str]:
    return [line for line in str(check_map(folder)).splitlines() if "zone" in line]


def test_shipped_zones_are_ok(folder: Path) -> None:
    assert check_map(folder).ok
    (line,) = zone_lines(folder)
    assert line.startswith("ok   zones: west corridor, north corridor")


def test_zones_that_overlap_or_lie_outside_are_told(folder: Path) -> None:
    (folder / ZONES_FILE).write_text(
        "[[zone]]\nname = 'a'\npolygon = [[0, 0], [4, 0], [4, 4], [0, 4]]\n"
        "[[zone]]\nname = 'b'\npolygon = [[3, 0], [5, 0], [5, 4], [3, 4]]\n"
        "[[zone]]\nname = 'far'\npolygon = [[90, 0], [95, 0], [95, 4]]\n"
    )
    assert zone_lines(folder) == [
        "ok   zones: a, b, far",
        "FAIL zone: 'far' lies outside the map",
        "ok   zone: 'b' is called 'a' where both are: first in the file",
    ]


def test_broken_zone_file_fails_and_the_border_is_still_checked(folder: Path) -> None:
    (folder / ZONES_FILE).write_text("[[zone]]\nname = 'a'\n")
    report = check_map(folder)
    assert not report.ok
    assert any("zones.toml" in line for line in zone_lines(folder))
    assert any(finding.subject == "clearance" for finding in report.findings)
