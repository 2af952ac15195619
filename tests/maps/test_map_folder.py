"""Map folders, and the shipped ones."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from maps.border import BorderError
from maps.map_folder import load_map_folder, map_folder_from_files
from maps.occupancy_map import MapError

MAPS = Path(__file__).resolve().parents[2] / "maps"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    copy = tmp_path / "somewhere"
    shutil.copytree(MAPS / "paper_lab", copy)
    return copy


@pytest.mark.parametrize(
    ("name", "border", "length", "closed", "tolerance"),
    [
        ("paper_lab", "border", 51.0, True, 0.005),
        ("paper_lab", "open", 25.0, False, 0.005),
        ("intel_lab", "border", 70.0, True, 1.0),
    ],
)
def test_shipped_maps_have_their_borders(
    name: str, border: str, length: float, closed: bool, tolerance: float
) -> None:
    content = load_map_folder(MAPS / name, border)
    assert content.name == name
    assert content.border is not None
    assert content.border.length == pytest.approx(length, abs=tolerance)
    assert content.border.closed is closed
    assert content.map.resolution == 0.05
    assert set(content.files) == {"map.yaml", "map.pgm", f"{border}.toml"}
    assert (MAPS / name / "README.md").is_file()


def test_files_restore_the_same_folder(folder: Path) -> None:
    content = load_map_folder(folder, "open")
    shutil.rmtree(folder)
    back = map_folder_from_files(content.name, content.files, "open")
    assert np.array_equal(back.map.cells, content.map.cells)
    assert back.map.origin == content.map.origin
    assert back.border is not None
    assert content.border is not None
    assert back.border.primitives == content.border.primitives
    assert back.files == content.files


def test_the_default_border_may_be_absent(folder: Path) -> None:
    (folder / "border.toml").unlink()
    content = load_map_folder(folder)
    assert content.border is None
    assert map_folder_from_files("m", content.files).border is None


def test_missing_named_border_is_refused(folder: Path) -> None:
    with pytest.raises(BorderError, match=r"somewhere/north\.toml: there is no such border"):
        load_map_folder(folder, "north")


def test_missing_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(
        MapError, match=r"nowhere/map\.yaml: cannot be read .* is this a map folder"
    ):
        load_map_folder(tmp_path / "nowhere")


def test_missing_image_is_named(folder: Path) -> None:
    (folder / "map.pgm").unlink()
    with pytest.raises(MapError, match=r"somewhere/map\.pgm: cannot be read"):
        load_map_folder(folder)


def test_image_outside_the_folder_is_refused(folder: Path) -> None:
    yaml = (folder / "map.yaml").read_text().replace("map.pgm", "../map.pgm")
    (folder / "map.yaml").write_text(yaml)
    with pytest.raises(MapError, match="must lie in the map folder"):
        load_map_folder(folder)


@pytest.mark.parametrize("absolute", [False, True])
def test_image_may_be_named_by_a_path_into_the_folder(folder: Path, absolute: bool) -> None:
    written = f"{folder}/map.pgm" if absolute else "./map.pgm"
    yaml = (folder / "map.yaml").read_text().replace("map.pgm", written)
    (folder / "map.yaml").write_text(yaml)
    content = load_map_folder(folder)
    assert set(content.files) == {"map.yaml", "map.pgm", "border.toml"}
    back = map_folder_from_files(content.name, content.files)
    assert np.array_equal(back.map.cells, content.map.cells)


@pytest.mark.parametrize("number", ["nan", "inf", "1e9", "1" + 300 * "0"])
def test_border_with_a_number_that_is_no_place_is_refused(folder: Path, number: str) -> None:
    text = f"closed = false\nvertices = [[0.0, 0.0], [{number}, 1.0]]\n"
    (folder / "border.toml").write_bytes(b"\xef\xbb\xbf" + text.encode())
    with pytest.raises(BorderError, match=r"border\.toml: ") as caught:
        load_map_folder(folder)
    assert len(str(caught.value)) < 300


def test_invalid_border_names_its_file(folder: Path) -> None:
    (folder / "border.toml").write_text("closed = 3\n")
    with pytest.raises(BorderError, match=r"somewhere/border\.toml: .*closed"):
        load_map_folder(folder)


@pytest.mark.parametrize("missing", ["map.yaml", "map.pgm"])
def test_incomplete_files_are_named(missing: str) -> None:
    files = dict(load_map_folder(MAPS / "paper_lab").files)
    del files[missing]
    with pytest.raises(MapError, match=rf"recorded/{missing}: missing"):
        map_folder_from_files("recorded", files)
