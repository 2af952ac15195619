"""Building maps from logs, checking and drawing map folders."""

from __future__ import annotations

import math
import shutil
from itertools import product
from pathlib import Path

import cv2
import numpy as np
import pytest

from maps.map_folder import load_map_folder
from maps.occupancy_map import FREE, OCCUPIED, UNKNOWN, MapError, load_map
from maps.pose import Pose
from tools.logs.carmen import CarmenLog, CarmenScan, read_carmen
from tools.mapping.map_build import build_map
from tools.mapping.map_check import check_map
from tools.mapping.map_picture import draw_map

MAPS = Path(__file__).resolve().parents[3] / "maps"
ROOM = (-3.0, 5.0, -2.0, 2.0)  # x from, x to, y from, y to


def scan_of_room(t: float, laser: Pose) -> CarmenScan:
    """Return the scan of a laser in an empty rectangular room."""
    angles = math.radians(-90.0) + math.radians(1.0) * np.arange(180)
    ux, uy = np.cos(laser.theta + angles), np.sin(laser.theta + angles)
    with np.errstate(divide="ignore"):
        to_x = np.maximum((ROOM[1] - laser.x) / ux, (ROOM[0] - laser.x) / ux)
        to_y = np.maximum((ROOM[3] - laser.y) / uy, (ROOM[2] - laser.y) / uy)
    return CarmenScan(
        t=t,
        ranges=np.minimum(to_x, to_y),
        angle_min=-math.pi / 2,
        angle_increment=math.radians(1.0),
        reference=laser,
        odometry=laser,
    )


def log_of_room(scans: list[CarmenScan] | None = None) -> CarmenLog:
    if scans is None:
        poses = [(0.0, 0.0, 0.3), (1.0, 0.5, -2.0), (-1.0, -0.5, 2.5), (2.0, 0.0, 0.0)]
        scans = [scan_of_room(float(t), Pose(*pose)) for t, pose in enumerate(poses)]
    return CarmenLog(path=Path("room.log"), scans=scans, odometry=[])


def test_a_room_is_free_inside_with_walls_where_they_are() -> None:
    built = build_map(log_of_room(), 0.1, min_sightings=1)
    occupancy = built.map
    rows, cols = np.nonzero(occupancy.cells == OCCUPIED)
    x = occupancy.origin.x + (cols + 0.5) * 0.1
    y = occupancy.origin.y + (rows + 0.5) * 0.1
    to_wall = np.minimum(
        np.minimum(abs(x - ROOM[0]), abs(x - ROOM[1])),
        np.minimum(abs(y - ROOM[2]), abs(y - ROOM[3])),
    )
    assert len(rows) > 150
    assert to_wall.max() < 0.08
    inside = occupancy.cells[occupancy.cells_at([(0.5, 0.0), (3.0, 1.0), (-2.0, -1.0)])]
    outside = occupancy.cells[occupancy.cells_at([(5.5, 0.0), (0.0, 2.5)])]
    assert (inside == FREE).all()
    assert (outside == UNKNOWN).all()


def test_counts_add_up() -> None:
    calls: list[float] = []
    built = build_map(log_of_room(), 0.1, progress=calls.append)
    assert built.scans == 4
    assert built.beams == 4 * 180
    assert built.free + built.occupied + built.unknown == built.map.cells.size
    assert calls == [1, 2, 3, 4]
    assert "4 scans" in built.summary()


def test_person_who_walked_by_is_not_in_the_map() -> None:
    poses = [Pose(0.0, 0.0, 0.0)] * 6
    scans = [scan_of_room(float(t), pose) for t, pose in enumerate(poses)]
    scans[2].ranges[85:95] = 1.5
    place = [(1.5, 0.0)]
    cells = build_map(log_of_room(scans), 0.1).map
    assert cells.cells[cells.cells_at(place)] == FREE
    cells = build_map(log_of_room(scans), 0.1, occupied_share=0.1).map
    assert cells.cells[cells.cells_at(place)] == OCCUPIED


def test_beams_beyond_the_limit_and_without_return_are_left_out() -> None:
    scan = scan_of_room(0.0, Pose(0.0, 0.0, 0.0))
    scan.ranges[:90] = math.inf
    built = build_map(log_of_room([scan]), 0.1, max_range=3.0, min_sightings=1)
    assert built.beams == int(np.count_nonzero(scan.ranges < 3.0))
    _, cols = np.nonzero(built.map.cells != UNKNOWN)
    assert built.map.origin.x + (cols.max() + 1) * 0.1 < 3.0 + 0.1


def test_even_and_odd_scans_are_those_of_the_log() -> None:
    log = log_of_room()
    even = build_map(log, 0.1, scans="even", min_sightings=1)
    odd = build_map(log, 0.1, scans="odd", min_sightings=1)
    alone = build_map(log_of_room([log.scans[1], log.scans[3]]), 0.1, min_sightings=1)
    assert (even.scans, odd.scans) == (2, 2)
    assert np.array_equal(odd.map.cells, alone.map.cells)
    assert not np.array_equal(even.map.cells, odd.map.cells)


def test_missing_scans_are_a_map_error() -> None:
    log = log_of_room([scan_of_room(0.0, Pose(0.0, 0.0, 0.0))])
    with pytest.raises(MapError, match=r"room\.log: no odd scans"):
        build_map(log, scans="odd")


@pytest.mark.parametrize("resolution", [0.0, -0.1, math.nan])
def test_invalid_resolution_is_a_map_error(resolution: float) -> None:
    with pytest.raises(MapError, match="positive number of metres"):
        build_map(log_of_room(), resolution)


def test_far_pose_is_a_map_error() -> None:
    log = log_of_room([scan_of_room(0.0, Pose(0.0, 0.0, 0.0))])
    far = CarmenScan(1.0, np.ones(180), -1.57, 0.0175, Pose(9e6, 5.0, 0.0), Pose(0.0, 0.0, 0.0))
    with pytest.raises(MapError, match=r"room\.log: the scans span 9000\d+ x \d+ m"):
        build_map(log_of_room([*log.scans, far]))


def test_intel_lab_is_built_from_its_log(data_folder: Path) -> None:
    log = read_carmen(data_folder / "logs" / "intel-corrected.log.gz")
    built = build_map(log)
    shipped = load_map(MAPS / "intel_lab" / "map.yaml")
    assert built.scans == 910
    assert built.map.origin == shipped.origin
    assert built.map.cells.shape == shipped.cells.shape
    # Another processor's cosine may move a point over a cell's edge.
    assert np.mean(built.map.cells != shipped.cells) < 1e-4


@pytest.mark.parametrize(
    ("name", "border"),
    list(product(("paper_lab", "intel_lab", "large_hall"), ("border", "open"))),
)
def test_shipped_maps_pass_the_check(name: str, border: str) -> None:
    report = check_map(MAPS / name, border)
    assert report.ok, str(report)
    assert {"map", "border", "clearance", "turning radius"} <= {f.subject for f in report.findings}


def failures(folder: Path, border: str = "border") -> str:
    report = check_map(folder, border)
    assert not report.ok
    return "\n".join(str(finding) for finding in report.findings if not finding.ok)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "closed = false\ncorner_radius = 1.0\nvertices = [[5.0, 13.75], [12.0, 14.7]]",
            "clearance",
        ),
        (
            "closed = false\ncorner_radius = 1.0\nvertices = [[4.0, 4.0], [4.0, 20.0]]",
            "leaves the map",
        ),
        ("closed = false\ncorner_radius = 1.0\nvertices = [[4, 4], [-0.3, 4]]", "unknown space"),
        (
            "closed = false\ncorner_radius = 1.0\nvertices = [[4, 9.9], [7, 9.9]]",
            "through a wall at x 5.2",
        ),
        (
            "closed = false\ncorner_radius = 0.3\nvertices = [[4, 4], [8, 4], [8, 3]]",
            "tightest 0.30",
        ),
        ("closed = true", "give either"),
    ],
)
def test_a_bad_border_fails_the_check_by_place(tmp_path: Path, text: str, words: str) -> None:
    folder = tmp_path / "map"
    shutil.copytree(MAPS / "paper_lab", folder)
    (folder / "border.toml").write_text(text)
    assert words in failures(folder)


def test_a_folder_without_map_border_or_walls_fails_the_check(tmp_path: Path) -> None:
    assert "cannot be read" in failures(tmp_path)
    folder = tmp_path / "map"
    shutil.copytree(MAPS / "paper_lab", folder)
    (folder / "map.pgm").write_bytes(b"P5\n520 370\n255\n" + b"\xfe" * (520 * 370))
    assert "occupied cells" in failures(folder)
    (folder / "border.toml").unlink()
    assert "border.toml is missing" in failures(folder)
    assert "no such border" in failures(folder, "north")


def test_the_picture_shows_map_and_border(tmp_path: Path) -> None:
    png = tmp_path / "out" / "map.png"
    draw_map(MAPS / "paper_lab", png)
    picture = cv2.imread(str(png))
    assert picture is not None
    content = load_map_folder(MAPS / "paper_lab")
    scale = picture.shape[1] // content.map.cells.shape[1]
    assert picture.shape[0] > content.map.cells.shape[0] * scale  # a caption below

    def color(x: float, y: float) -> list[int]:
        (row,), (col,) = content.map.cells_at([(x, y)])
        top_down = content.map.cells.shape[0] - 1 - row
        return [int(v) for v in picture[top_down * scale + scale // 2, col * scale + scale // 2]]

    assert color(12.0, 0.0) == [40, 40, 40]  # the building's south wall
    assert color(1.3, 1.3) == [255, 255, 255]  # a room
    assert color(-0.4, -0.4) == [205, 205, 205]  # outside
    (row,), (col,) = content.map.cells_at([(7.0, 13.75)])
    top = (content.map.cells.shape[0] - 1 - row) * scale
    across = picture[top - 3 * scale : top + 3 * scale, col * scale].tolist()
    assert [60, 150, 0] in across  # green: enough clearance


def test_picture_without_a_border_is_drawn(tmp_path: Path) -> None:
    folder = tmp_path / "map"
    shutil.copytree(MAPS / "paper_lab", folder)
    (folder / "border.toml").unlink()
    draw_map(folder, tmp_path / "map.png")
    assert (tmp_path / "map.png").stat().st_size > 1000
