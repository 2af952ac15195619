"""Maps of pictures of any kind."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from maps.occupancy_map import FREE, OCCUPIED, UNKNOWN, MapError
from tools.mapping.picture_import import import_picture


def plan(*, gap: bool = False) -> np.ndarray:
    """Return a grey picture, 60 x 40: a black outline on white."""
    grey = np.full((40, 60), 255, dtype=np.uint8)
    grey[5, 5:55] = grey[34, 5:55] = 0
    grey[5:35, 5] = grey[5:35, 54] = 0
    if gap:
        grey[20, 5] = 255
    return grey


def saved(folder: Path, pixels: np.ndarray) -> Path:
    path = folder / "plan.png"
    path.write_bytes(cv2.imencode(".png", pixels)[1].tobytes())
    return path


@pytest.mark.parametrize("kind", ["grey", "rgb", "rgba", "16 bit"])
def test_pictures_of_every_kind_make_the_same_map(tmp_path: Path, kind: str) -> None:
    grey = plan()
    pixels = {
        "grey": grey,
        "rgb": np.dstack([grey] * 3),
        "rgba": np.dstack([np.zeros_like(grey)] * 3 + [255 - grey]),  # black on transparent
        "16 bit": grey.astype(np.uint16) * 257,
    }[kind]
    imported = import_picture(saved(tmp_path, pixels), 0.05)
    cells = imported.map.cells
    assert imported.map.size == pytest.approx((3.0, 2.0))
    assert (cells[5, 10], cells[20, 20], cells[2, 2]) == (OCCUPIED, FREE, UNKNOWN)
    assert "outside, unknown" in imported.summary


def test_first_row_of_the_picture_is_the_top_of_the_map(tmp_path: Path) -> None:
    grey = plan()
    grey[10, 20] = 0
    cells = import_picture(saved(tmp_path, grey), 0.05).map.cells
    assert cells[29, 20] == OCCUPIED
    assert cells[10, 20] == FREE


def test_an_open_outline_is_told_and_all_outside_is_free(tmp_path: Path) -> None:
    imported = import_picture(saved(tmp_path, plan(gap=True)), 0.05)
    assert "has a gap" in imported.summary
    assert imported.map.cells[2, 2] == FREE


def test_grey_lines_are_walls_from_the_share_given(tmp_path: Path) -> None:
    path = saved(tmp_path, np.maximum(plan(), 160))
    with pytest.raises(MapError, match="lower --dark"):
        import_picture(path, 0.05)
    assert import_picture(path, 0.05, dark=0.2).map.cells[5, 10] == OCCUPIED


def test_what_is_no_picture_is_one_line(tmp_path: Path) -> None:
    path = tmp_path / "plan.png"
    path.write_bytes(b"%PDF-1.4")
    with pytest.raises(MapError, match="not a readable picture"):
        import_picture(path, 0.05)
