"""Occupancy maps: the map_server format in and out, cells, distances."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from maps.occupancy_map import (
    FREE,
    OCCUPIED,
    UNKNOWN,
    MapError,
    OccupancyMap,
    Surface,
    load_map,
    save_map,
)
from maps.pose import Pose

# Top row first, as in an image: # occupied, . free, ? unknown.
DRAWN = """
#####
#..?#
#...#
##..#
#####
"""
YAML = """
image: map.pgm
resolution: 0.1
origin: [-1.0, 2.0, 0.0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
"""


def drawn_cells() -> np.ndarray:
    state = {"#": OCCUPIED, ".": FREE, "?": UNKNOWN}
    rows = [[state[sign] for sign in line] for line in DRAWN.split()]
    return np.array(rows[::-1], dtype=np.uint8)


def write_map(folder: Path, yaml: str = YAML, image: bytes | None = None) -> Path:
    grey = {OCCUPIED: 0, FREE: 254, UNKNOWN: 205}
    pixels = bytes(grey[int(cell)] for cell in drawn_cells()[::-1].ravel())
    (folder / "map.pgm").write_bytes(image or b"P5\n# drawn by hand\n5 5\n255\n" + pixels)
    path = folder / "map.yaml"
    path.write_text(yaml)
    return path


def test_image_row_0_is_the_top_and_array_row_0_the_bottom(tmp_path: Path) -> None:
    occupancy = load_map(write_map(tmp_path))
    assert np.array_equal(occupancy.cells, drawn_cells())
    assert occupancy.cells[1, 1] == OCCUPIED  # the bump is low on the left
    assert occupancy.cells[3, 3] == UNKNOWN
    assert occupancy.resolution == 0.1
    assert occupancy.origin == Pose(-1.0, 2.0, 0.0)
    assert occupancy.size == pytest.approx((0.5, 0.5))


def test_plain_text_image_gives_the_same_map(tmp_path: Path) -> None:
    grey = {OCCUPIED: 0, FREE: 254, UNKNOWN: 205}
    values = " ".join(str(grey[int(cell)]) for cell in drawn_cells()[::-1].ravel())
    path = write_map(tmp_path, image=f"P2\n5 5\n255\n{values}\n".encode())
    assert np.array_equal(load_map(path).cells, drawn_cells())


def test_negate_swaps_dark_and_light(tmp_path: Path) -> None:
    path = write_map(tmp_path, YAML.replace("negate: 0", "negate: 1"))
    cells = load_map(path).cells
    assert cells[0, 0] == FREE  # black
    assert cells[2, 2] == OCCUPIED  # white
    assert cells[3, 3] == OCCUPIED  # 205 / 255 is above the threshold


def test_thresholds_are_strict(tmp_path: Path) -> None:
    # Darkness of 255, 204, 153, 102, 51: exactly 0, 0.2, 0.4, 0.6, 0.8.
    image = b"P5\n5 1\n255\n" + bytes([255, 204, 153, 102, 51])
    yaml = YAML.replace("0.65", "0.6").replace("0.196", "0.2")
    cells = load_map(write_map(tmp_path, yaml, image)).cells
    assert cells.tolist() == [[FREE, UNKNOWN, UNKNOWN, UNKNOWN, OCCUPIED]]


@given(
    cells=arrays(
        np.uint8, array_shapes(min_dims=2, max_dims=2, max_side=7), elements=st.integers(0, 2)
    ),
    resolution=st.floats(1e-6, 100.0),
    x=st.floats(-1e9, 1e9),
    y=st.floats(-1e9, 1e9),
    surface=st.sampled_from(Surface),
)
def test_round_trip_is_lossless(
    tmp_path_factory: pytest.TempPathFactory,
    cells: np.ndarray,
    resolution: float,
    x: float,
    y: float,
    surface: Surface,
) -> None:
    folder = tmp_path_factory.mktemp("map")
    save_map(OccupancyMap(cells, resolution, Pose(x, y, 0.0), surface), folder)
    back = load_map(folder / "map.yaml")
    assert np.array_equal(back.cells, cells)
    assert back.resolution == resolution
    assert back.origin == Pose(x, y, 0.0)
    assert back.surface is surface


@pytest.mark.parametrize(
    ("yaml", "image", "words"),
    [
        (YAML.replace("map.pgm", "gone.pgm"), None, ["gone.pgm", "cannot be read", "correct"]),
        (YAML + "mode: scale\n", None, ["map.yaml", "scale", "mode: trinary"]),
        (YAML + "surface: back\n", None, ["map.yaml", "surface", "'face'", "'centre'", "'back'"]),
        (YAML + "mode: raw\n", None, ["map.yaml", "raw"]),
        (YAML.replace("2.0, 0.0", "2.0, 0.3"), None, ["map.yaml", "yaw 0.3", "turn the image"]),
        (YAML.replace("0.196", "0.7"), None, ["map.yaml", "free_thresh < occupied_thresh"]),
        (YAML.replace("0.65", "1.5"), None, ["map.yaml", "occupied_thresh <= 1"]),
        (YAML.replace("0.65", "high"), None, ["map.yaml", "occupied_thresh", "'high'"]),
        (YAML.replace("resolution: 0.1", "resolution: 0"), None, ["resolution 0.0"]),
        (YAML.replace("resolution: 0.1", "resolution: .nan"), None, ["map.yaml", "resolution"]),
        (YAML.replace("resolution: 0.1", ""), None, ["map.yaml", "'resolution' is missing"]),
        (YAML.replace("[-1.0, 2.0, 0.0]", "[1.0, 2.0]"), None, ["map.yaml", "[x, y, yaw]"]),
        (YAML.replace("negate: 0", "negate: 2"), None, ["map.yaml", "negate", "0 or 1"]),
        ("- a list", None, ["map.yaml", "not a map description"]),
        ("image: [", None, ["map.yaml", "not YAML"]),
        ("image: \x01", None, ["map.yaml", "not YAML"]),
        (YAML, b"no image at all", ["map.pgm", "not a readable image"]),
        (YAML, b"P6\n1 1\n255\n\x00\x01\x02", ["map.pgm", "8-bit grey"]),
        (YAML, b"P5\n1 1\n65535\n\x00\x01", ["map.pgm", "save it with 255"]),
        (YAML, b"P5\n1 1\n100\n\x64", ["map.pgm", "save it with 255"]),
    ],
)
def test_invalid_map_gives_one_line_with_file_and_remedy(
    tmp_path: Path, yaml: str, image: bytes | None, words: list[str]
) -> None:
    path = write_map(tmp_path, yaml, image)
    with pytest.raises(MapError) as caught:
        load_map(path)
    message = str(caught.value)
    assert "\n" not in message
    assert str(tmp_path) in message
    for word in words:
        assert word in message


def test_missing_description_is_a_map_error(tmp_path: Path) -> None:
    with pytest.raises(MapError, match=r"map\.yaml: cannot be read"):
        load_map(tmp_path / "map.yaml")


def test_empty_image_is_a_map_error(tmp_path: Path) -> None:
    path = write_map(tmp_path)
    (tmp_path / "map.pgm").write_bytes(b"")
    with pytest.raises(MapError, match=r"map\.pgm: the image is empty"):
        load_map(path)


@pytest.mark.parametrize(
    ("cells", "resolution", "origin"),
    [
        (np.zeros((0, 3), np.uint8), 0.1, Pose(0, 0, 0)),
        (np.zeros(3, np.uint8), 0.1, Pose(0, 0, 0)),
        (np.full((2, 2), 3, np.uint8), 0.1, Pose(0, 0, 0)),
        (np.zeros((2, 2), np.uint8), -0.1, Pose(0, 0, 0)),
        (np.zeros((2, 2), np.uint8), 0.1, Pose(0, math.inf, 0)),
        (np.zeros((2, 2), np.uint8), 0.1, Pose(0, 0, 0.1)),
    ],
)
def test_impossible_maps_are_refused(cells: np.ndarray, resolution: float, origin: Pose) -> None:
    with pytest.raises(MapError):
        OccupancyMap(cells, resolution, origin)


def test_cells_at_counts_from_the_offset_origin() -> None:
    occupancy = OccupancyMap(drawn_cells(), 0.1, Pose(-1.0, 2.0, 0.0))
    points = [(-0.95, 2.05), (-0.55, 2.45), (-0.65, 2.35), (-1.01, 2.05), (-0.95, 2.51)]
    rows, cols = occupancy.cells_at(points)
    assert rows.tolist() == [0, 4, 3, 0, 5]
    assert cols.tolist() == [0, 4, 3, -1, 0]
    assert occupancy.inside(rows, cols).tolist() == [True, True, True, False, False]


def test_distance_field_equals_brute_force() -> None:
    cells = np.full((9, 13), FREE, dtype=np.uint8)
    cells[2, 3] = cells[7, 11] = OCCUPIED
    cells[0, 0] = UNKNOWN  # not a wall
    field = OccupancyMap(cells, 0.05, Pose(3.0, -4.0, 0.0)).distance_field()
    rows, cols = np.mgrid[0:9, 0:13]
    nearest = np.minimum(np.hypot(rows - 2, cols - 3), np.hypot(rows - 7, cols - 11))
    assert field.dtype == np.float32
    np.testing.assert_allclose(field, 0.05 * nearest, atol=1e-6)


def test_distance_field_without_walls_is_infinite() -> None:
    field = OccupancyMap(np.zeros((3, 3), np.uint8), 0.05, Pose(0, 0, 0)).distance_field()
    assert np.isinf(field).all()
