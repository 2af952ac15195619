"""The draft of a border and its file."""

from __future__ import annotations

from pathlib import Path

import pytest

from maps.border import BorderError
from tools.border_editor.border_draft import (
    BorderDraft,
    Vertex,
    fitting_radius,
    read_draft,
    save_draft,
)

SQUARE = BorderDraft(
    vertices=[Vertex(0, 0), Vertex(0, 8, 2.0), Vertex(8, 8), Vertex(8, 0)], corner_radius=1.0
)


def test_a_draft_comes_back_from_its_file(tmp_path: Path) -> None:
    file = tmp_path / "border.toml"
    save_draft(SQUARE, file)
    assert read_draft(file) == (SQUARE, "")
    assert read_draft(tmp_path / "none.toml") == (BorderDraft(), "")


def test_what_was_there_is_kept_beside_it(tmp_path: Path) -> None:
    file = tmp_path / "border.toml"
    file.write_text("closed = false # mine\n")
    save_draft(SQUARE, file)
    assert (tmp_path / "border.toml.before").read_text() == "closed = false # mine\n"


def test_what_is_no_border_is_not_saved(tmp_path: Path) -> None:
    file = tmp_path / "border.toml"
    with pytest.raises(BorderError, match="needs at least 3"):
        save_draft(BorderDraft(vertices=[Vertex(0, 0)]), file)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("closed = true\n[[segment]]\nfrom = [0.0, 0.0]\nto = [1.0, 0.0]\n", "in pieces"),
        ("closed = maybe\n", "saving replaces it"),
        ("closed = true\nvertices = [[1e9, 0.0]]\n", "saving replaces it"),
    ],
)
def test_a_file_that_cannot_be_drawn_makes_an_empty_draft_and_says_why(
    tmp_path: Path, content: str, said: str
) -> None:
    file = tmp_path / "border.toml"
    file.write_text(content)
    draft, trouble = read_draft(file)
    assert draft.vertices == []
    assert said in trouble


def test_radius_leaves_half_of_the_shorter_line() -> None:
    corner = fitting_radius(Vertex(0, 4), Vertex(0, 0), Vertex(1, 0), 1.25)
    assert corner == pytest.approx(0.499)
    assert fitting_radius(Vertex(0, 4), Vertex(0, 0), Vertex(4, 0), 1.25) == 1.25
    assert fitting_radius(Vertex(0, 4), Vertex(0, 0), Vertex(0, -4), 1.25) == 1.25
