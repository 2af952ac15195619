"""Border files (TOML): vertices with rounded corners, or explicit segments and arcs.

By vertices; a third number is that corner's own radius::

    closed = true
    corner_radius = 1.25                          # m, for corners without their own
    vertices = [[0.0, 0.0], [10.0, 0.0, 1.5], [10.0, 6.0], [0.0, 6.0]]

By pieces, in any order; they are chained where they meet, from the first point (``closed =
false``) or from the first piece of the file::

    closed = false
    [[segment]]
    from = [0.0, 0.0]
    to = [4.0, 0.0]
    [[arc]]
    from = [4.0, 0.0]
    to = [5.0, 1.0]
    center = [4.0, 1.0]
    turn = "left"                                 # or "right"
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

import msgspec

from maps.border import Border, BorderError, describe
from maps.border_primitives import Arc, Point, Primitive, Segment
from maps.input_limits import MAX_BORDER_PIECES, MAX_COORDINATE_M
from maps.rounded_polygon import round_polygon
from maps.toml_text import TomlError, leaves, read_toml

_MEETING = 1e-3  # m within which two ends are the same point
_OF_AN_END = 1.0  # m; the ends of an open border have no corner

_Radius = Annotated[float, msgspec.Meta(gt=0.0)]  # m
_Vertex = Annotated[list[float], msgspec.Meta(min_length=2, max_length=3)]  # x, y[, radius] in m


class SegmentEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A straight piece, m in the map frame."""

    start: Point = msgspec.field(name="from")
    to: Point


class ArcEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A circular piece, m in the map frame."""

    start: Point = msgspec.field(name="from")
    to: Point
    center: Point
    turn: Literal["left", "right"]


class BorderEntries(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The content of a border file."""

    closed: bool
    vertices: list[_Vertex] | None = None
    corner_radius: _Radius | None = None
    segment: list[SegmentEntry] = []
    arc: list[ArcEntry] = []


def read_border(data: bytes, place: str) -> Border:
    """Decode a border file's bytes; raises BorderError, which names the file by ``place``."""
    try:
        entries = msgspec.convert(read_toml(data), BorderEntries)
        return _border_of(entries)
    except (msgspec.MsgspecError, BorderError, TomlError) as error:
        raise BorderError(f"{place}: {error}") from None


def _border_of(entries: BorderEntries) -> Border:
    for _place, number in leaves(msgspec.to_builtins(entries)):
        if not isinstance(number, int | float) or abs(number) <= MAX_COORDINATE_M:
            continue
        # NaN comes here too
        raise BorderError(f"has {number!s:.20}, beyond {MAX_COORDINATE_M:g} m; correct it")
    count = max(len(entries.vertices or ()), len(entries.segment) + len(entries.arc))
    if count > MAX_BORDER_PIECES:
        raise BorderError(f"has {count} vertices or pieces, more than {MAX_BORDER_PIECES}: thin it")
    pieces = bool(entries.segment or entries.arc)
    if pieces == (entries.vertices is not None):
        raise BorderError("give either 'vertices' or [[segment]] and [[arc]] entries")
    if entries.vertices is None:
        if entries.corner_radius is not None:
            raise BorderError("'corner_radius' belongs to 'vertices', remove it")
        return Border(_chain(_pieces(entries), closed=entries.closed), closed=entries.closed)
    points = [(vertex[0], vertex[1]) for vertex in entries.vertices]
    radii = [
        _radius(entries, number, vertex) for number, vertex in enumerate(entries.vertices, start=1)
    ]
    return round_polygon(points, radii, closed=entries.closed)


def _radius(entries: BorderEntries, number: int, vertex: list[float]) -> float:
    radius = vertex[2] if len(vertex) == 3 else entries.corner_radius
    assert entries.vertices is not None
    if radius is None and not entries.closed and number in (1, len(entries.vertices)):
        return _OF_AN_END
    if radius is None:
        raise BorderError(f"vertex {number} has no radius, give it one or set 'corner_radius'")
    if radius <= 0.0:
        raise BorderError(f"vertex {number} has the radius {radius:g} m, it must be positive")
    return radius


def _pieces(entries: BorderEntries) -> list[Primitive]:
    segments: list[Primitive] = [Segment(entry.start, entry.to) for entry in entries.segment]
    return segments + [_arc_of(number, entry) for number, entry in enumerate(entries.arc)]


def _arc_of(number: int, entry: ArcEntry) -> Arc:
    radius, end_radius = math.dist(entry.center, entry.start), math.dist(entry.center, entry.to)
    if abs(radius - end_radius) > _MEETING or radius == 0.0:
        raise BorderError(
            f"arc {number + 1}: its ends are {radius:.3f} and {end_radius:.3f} m from its center, "
            "move the center"
        )
    start_angle, end_angle = (
        math.atan2(y - entry.center[1], x - entry.center[0]) for x, y in (entry.start, entry.to)
    )
    sweep = (end_angle - start_angle) % math.tau
    return Arc(
        entry.center, radius, start_angle, sweep if entry.turn == "left" else sweep - math.tau
    )


def _chain(pieces: list[Primitive], *, closed: bool) -> list[Primitive]:
    """Return the pieces ordered so that each starts where the one before ends."""
    first = 0 if closed else _first_piece(pieces)
    chained, rest = [pieces[first]], pieces[:first] + pieces[first + 1 :]
    while rest:
        end = chained[-1].end
        following = min(rest, key=lambda piece: math.dist(end, piece.start))
        # A gap stays: Border's own check reports it with both ends.
        chained.append(following)
        rest.remove(following)
    return chained


def _first_piece(pieces: list[Primitive]) -> int:
    """Return the index of the piece whose start is no other piece's end."""
    firsts = [
        index
        for index, piece in enumerate(pieces)
        if all(math.dist(piece.start, other.end) > _MEETING for other in pieces)
    ]
    if not firsts:
        raise BorderError("the pieces close a loop, set closed = true")
    if len(firsts) > 1:
        names = " and ".join(describe(index, pieces[index]) for index in firsts[:2])
        raise BorderError(f"no piece ends where {names} start, make the pieces meet")
    return firsts[0]
