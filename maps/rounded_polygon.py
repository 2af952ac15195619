"""Borders drawn as vertices: straight lines whose corners are rounded by tangent arcs."""

from __future__ import annotations

import math
from collections.abc import Sequence

from maps.border import Border, BorderError
from maps.border_primitives import Arc, Point, Primitive, Segment
from maps.pose import wrap_angle

_STRAIGHT = 1e-9  # rad; corners that turn less are ignored
_EMPTY = 1e-6  # m; shorter lines between two arcs are left out


def round_polygon(
    vertices: Sequence[Point], corner_radii: Sequence[float], *, closed: bool
) -> Border:
    """Return the border along the vertices, each corner replaced by an arc of its radius.

    vertices: m in the map frame. corner_radii: m, one per vertex (those of the two ends of an
    open border are not used). A closed border starts (s = 0) where the first vertex's arc ends,
    going clockwise, so it is the same border whichever way round its vertices are listed.

    Raises BorderError naming the vertex that cannot be rounded.
    """
    _check_vertices(vertices, closed=closed)
    numbers = list(range(len(vertices)))
    if closed and _signed_area(vertices) > 0.0:
        numbers = [0, *reversed(numbers[1:])]
    corners = numbers if closed else numbers[1:-1]
    neighbors = {
        number: (numbers[place - 1], numbers[(place + 1) % len(numbers)])
        for place, number in enumerate(numbers)
    }
    turns = {n: _turn(vertices, neighbors[n][0], n, neighbors[n][1]) for n in corners}
    cuts = {n: corner_radii[n] * math.tan(abs(turns[n]) / 2) for n in corners}
    primitives: list[Primitive] = []
    for number in numbers if closed else numbers[:-1]:
        following = neighbors[number][1]
        line = _line_between(vertices, number, following, cuts)
        if line is not None:
            primitives.append(line)
        if following in corners and abs(turns[following]) > _STRAIGHT:
            before = math.atan2(
                vertices[following][1] - vertices[number][1],
                vertices[following][0] - vertices[number][0],
            )
            primitives.append(
                _corner_arc(vertices[following], before, turns[following], corner_radii[following])
            )
    return Border(primitives, closed=closed)


def _check_vertices(vertices: Sequence[Point], *, closed: bool) -> None:
    needed = 3 if closed else 2
    if len(vertices) < needed:
        kind = "closed" if closed else "open"
        raise BorderError(
            f"{len(vertices)} vertices, a border that is {kind} needs at least {needed}"
        )
    for number in range(len(vertices) if closed else len(vertices) - 1):
        if vertices[number] == vertices[(number + 1) % len(vertices)]:
            raise BorderError(f"vertex {number + 1} is the same as the next, remove one")


def _turn(vertices: Sequence[Point], before: int, corner: int, after: int) -> float:
    """Return the change of heading at a corner, rad, positive to the left."""
    (x0, y0), (x1, y1), (x2, y2) = vertices[before], vertices[corner], vertices[after]
    turn = wrap_angle(math.atan2(y2 - y1, x2 - x1) - math.atan2(y1 - y0, x1 - x0))
    if abs(turn) > math.radians(179.0):
        raise BorderError(f"the border turns back on itself at vertex {corner + 1}, move it aside")
    return turn


def _line_between(
    vertices: Sequence[Point], number: int, following: int, cuts: dict[int, float]
) -> Segment | None:
    """Return the straight part between the arcs of neighbouring vertices; None if they touch."""
    (x0, y0), (x1, y1) = vertices[number], vertices[following]
    length = math.dist((x0, y0), (x1, y1))
    first, last = cuts.get(number, 0.0), cuts.get(following, 0.0)
    if first + last > length + _EMPTY:
        raise BorderError(
            f"the corners at vertices {number + 1} and {following + 1} need {first + last:.3f} m "
            f"of the {length:.3f} m between them, make their radii smaller"
        )
    if length - first - last <= _EMPTY:
        return None
    ux, uy = (x1 - x0) / length, (y1 - y0) / length
    return Segment((x0 + first * ux, y0 + first * uy), (x1 - last * ux, y1 - last * uy))


def _corner_arc(vertex: Point, heading: float, turn: float, radius: float) -> Arc:
    """Return the arc tangent to the lines into (``heading``) and out of (``+ turn``) a vertex."""
    side = math.copysign(1.0, turn)
    cut = radius * math.tan(abs(turn) / 2)
    center = (
        vertex[0] - cut * math.cos(heading) - side * radius * math.sin(heading),
        vertex[1] - cut * math.sin(heading) + side * radius * math.cos(heading),
    )
    return Arc(center, radius, heading - side * math.pi / 2, turn)


def _signed_area(vertices: Sequence[Point]) -> float:
    """Return the polygon's area, m2, positive if its vertices run counter-clockwise."""
    following = [*vertices[1:], vertices[0]]
    return (
        sum(x0 * y1 - x1 * y0 for (x0, y0), (x1, y1) in zip(vertices, following, strict=True)) / 2
    )
