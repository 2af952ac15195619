"""A border while it is drawn: its vertices, and the file it is saved as."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import msgspec

from maps.border import Border
from maps.border_file import BorderEntries, read_border
from maps.input_limits import MAX_BORDER_PIECES, MAX_COORDINATE_M
from maps.toml_text import TomlError, read_toml
from tools.border_editor.kept_file import write_kept

DEFAULT_RADIUS = 1.25
"""m of corners, in a building's corridors; the paper's map has it."""

_Coordinate = Annotated[float, msgspec.Meta(ge=-MAX_COORDINATE_M, le=MAX_COORDINATE_M)]


class Vertex(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A corner at x, y in m in the map frame; radius, m, of its own, None: the draft's."""

    x: _Coordinate
    y: _Coordinate
    radius: Annotated[float, msgspec.Meta(gt=0.0, le=MAX_COORDINATE_M)] | None = None


class BorderDraft(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What is drawn; it need not be a border yet."""

    closed: bool = True
    corner_radius: Annotated[float, msgspec.Meta(gt=0.0, le=MAX_COORDINATE_M)] = DEFAULT_RADIUS
    vertices: Annotated[list[Vertex], msgspec.Meta(max_length=MAX_BORDER_PIECES)] = []

    def border(self) -> Border:
        """Return the border as robots will read it. Raises BorderError."""
        return read_border(self.text().encode(), "this border")

    def text(self) -> str:
        """Return the content of its file."""
        numbers = [(each.x, each.y, each.radius) for each in self.vertices]
        rows = [f"    [{', '.join(f'{n:.3f}' for n in row if n is not None)}]," for row in numbers]
        return "\n".join(
            [
                "# Drawn by patrol map border. Metres in the map frame; a third number of a vertex",
                "# is the radius of that corner.",
                f"closed = {str(self.closed).lower()}",
                f"corner_radius = {self.corner_radius:.3f}",
                "vertices = [",
                *rows,
                "]",
                "",
            ]
        )


def read_draft(path: Path) -> tuple[BorderDraft, str]:
    """Return the draft of a border file, and why it is not what the file holds; empty if it is.

    A file that is missing makes an empty draft. Raises OSError.
    """
    if not path.exists():
        return BorderDraft(), ""
    try:
        entries = msgspec.convert(read_toml(path.read_bytes()), BorderEntries)
        draft = BorderDraft(
            closed=entries.closed,
            corner_radius=entries.corner_radius or DEFAULT_RADIUS,
            vertices=[Vertex(*vertex) for vertex in entries.vertices or ()],
        )
        draft = msgspec.convert(msgspec.to_builtins(draft), BorderDraft)
    except (msgspec.MsgspecError, TomlError) as error:
        return BorderDraft(), f"{path.name}: {error}; saving replaces it"
    if entries.vertices is None:
        return draft, f"{path.name} is drawn in pieces, not vertices; saving replaces them"
    return draft, ""


def save_draft(draft: BorderDraft, path: Path) -> None:
    """Write a draft to a border file; one that is there is kept beside it, as ``.before``.

    Raises BorderError if it is no border, and OSError.
    """
    draft.border()
    write_kept(path, draft.text())


def fitting_radius(before: Vertex, corner: Vertex, after: Vertex, most: float) -> float:
    """Return the largest radius, m, up to ``most``, that leaves both lines half their length."""
    into, out = (math.dist((corner.x, corner.y), (end.x, end.y)) for end in (before, after))
    turn = math.remainder(
        math.atan2(after.y - corner.y, after.x - corner.x)
        - math.atan2(corner.y - before.y, corner.x - before.x),
        math.tau,
    )
    bend = math.tan(min(abs(turn), math.pi - 0.02) / 2.0)
    return most if bend < 1e-6 else min(most, 0.499 * min(into, out) / bend)
