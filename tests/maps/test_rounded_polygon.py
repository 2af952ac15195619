"""Borders by vertices and corner radii."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from maps.border import BorderError
from maps.border_primitives import Arc
from maps.rounded_polygon import round_polygon

SQUARE = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)]


@given(radius=st.floats(0.01, 5.0))
def test_each_right_corner_shortens_the_border_by_its_known_length(radius: float) -> None:
    border = round_polygon(SQUARE, [radius] * 4, closed=True)
    assert border.length == pytest.approx(40.0 - (8.0 - 2.0 * math.pi) * radius)
    assert border.tightest_radius == radius


def test_radii_that_just_fit_leave_no_segment() -> None:
    border = round_polygon(SQUARE, [5.0] * 4, closed=True)
    assert all(isinstance(primitive, Arc) for primitive in border.primitives)
    assert border.length == pytest.approx(10.0 * math.pi)


def test_a_vertex_on_a_straight_line_is_no_corner() -> None:
    border = round_polygon([(0, 0), (2, 0), (5, 0)], [1.0] * 3, closed=False)
    assert border.length == pytest.approx(5.0)
    assert math.isinf(border.tightest_radius)


def test_each_vertex_may_have_its_own_radius() -> None:
    border = round_polygon(SQUARE, [1.0, 2.0, 3.0, 4.0], closed=True)
    # The square is clockwise 1, 4, 3, 2 and starts after its first corner.
    arcs = [primitive for primitive in border.primitives if isinstance(primitive, Arc)]
    assert [arc.radius for arc in arcs] == [4.0, 3.0, 2.0, 1.0]
    assert border.at(0.0)[:2] == pytest.approx((0.0, 1.0))


@pytest.mark.parametrize(
    ("vertices", "radius", "closed", "words"),
    [
        (SQUARE, 5.1, True, ["vertices", "10.200 m", "10.000 m", "smaller"]),
        (SQUARE[:2], 1.0, True, ["at least 3"]),
        (SQUARE[:1], 1.0, False, ["at least 2"]),
        ([(0, 0), (0, 0), (1, 1)], 0.1, False, ["vertex 1 is the same"]),
        ([(0, 0), (5, 0), (1, 0)], 0.1, False, ["vertex 2", "turns back"]),
        ([(0, 0), (4, 0), (4, 4), (2, 4), (2, -4)], 0.5, False, ["meets"]),
    ],
)
def test_invalid_vertices_are_refused_by_number(
    vertices: list[tuple[float, float]], radius: float, closed: bool, words: list[str]
) -> None:
    with pytest.raises(BorderError) as caught:
        round_polygon(vertices, [radius] * len(vertices), closed=closed)
    for word in words:
        assert word in str(caught.value)
