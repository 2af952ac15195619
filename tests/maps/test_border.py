"""Borders: abscissa, orientation, projection, and the checks of their pieces."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from maps.border import Border, BorderError
from maps.border_primitives import Arc, Segment
from maps.rounded_polygon import round_polygon

L_SHAPE = [(0.0, 0.0), (12.0, 0.0), (12.0, 5.0), (7.0, 5.0), (7.0, 9.0), (0.0, 9.0)]
CLOSED = round_polygon(L_SHAPE, [1.0, 1.5, 0.8, 1.2, 1.0, 1.3], closed=True)
OPEN = round_polygon(
    [(0.0, 0.0), (6.0, 0.0), (8.0, 5.0), (3.0, 9.0)], [0.0, 1.0, 1.4, 0.0], closed=False
)
CIRCLE = Border([Arc((1.0, 2.0), 3.0, 0.5, 2 * math.pi)], closed=True)
BORDERS = [CLOSED, OPEN, CIRCLE]

borders = st.sampled_from(BORDERS)
shares = st.floats(0.0, 1.0, exclude_max=True)
coordinates = st.floats(-4.0, 16.0)


@given(border=borders, share=shares)
def test_projecting_a_point_of_the_border_gives_its_abscissa(border: Border, share: float) -> None:
    s = share * border.length
    point = border.at(s)
    projection = border.project(point.x, point.y)
    assert abs(border.difference(projection.abscissa, s)) < 1e-6
    assert projection.distance < 1e-9
    assert (projection.x, projection.y) == pytest.approx((point.x, point.y), abs=1e-9)
    assert projection.tangent == pytest.approx((point.tx, point.ty), abs=1e-6)
    # On the border a direction is still defined.
    assert math.hypot(*projection.normal) == pytest.approx(1.0)
    assert projection.side in (-1, 1)


@given(border=borders, share=shares)
def test_tangent_is_a_unit_vector_along_growing_s(border: Border, share: float) -> None:
    s, step = share * border.length, 1e-5
    here, ahead = border.at(s), border.at(s + step)
    assert math.hypot(here.tx, here.ty) == pytest.approx(1.0)
    if border.closed or s + step < border.length:
        moved = ((ahead.x - here.x) / step, (ahead.y - here.y) / step)
        assert moved == pytest.approx((here.tx, here.ty), abs=1e-4)


@given(border=borders, share=shares)
def test_curvature_is_the_turning_rate_of_the_tangent(border: Border, share: float) -> None:
    s, step = share * border.length, 1e-6
    here, ahead = border.at(s), border.at(s + step)
    if here.curvature == ahead.curvature and (border.closed or s + step < border.length):
        turned = here.tx * ahead.ty - here.ty * ahead.tx
        assert turned / step == pytest.approx(here.curvature, abs=1e-3)


@given(border=borders, x=coordinates, y=coordinates)
@settings(max_examples=200)
def test_projection_equals_the_nearest_point_of_a_dense_polyline(
    border: Border, x: float, y: float
) -> None:
    points = DENSE[BORDERS.index(border)]
    nearest = float(np.hypot(*(points - (x, y)).T).min())
    projection = border.project(x, y)
    assert projection.distance == pytest.approx(nearest, abs=1e-3)
    foot = border.at(projection.abscissa)
    assert (projection.x, projection.y) == pytest.approx((foot.x, foot.y), abs=1e-9)
    assert math.dist((x, y), (foot.x, foot.y)) == pytest.approx(projection.distance, abs=1e-9)
    left = projection.tangent[0] * (y - foot.y) - projection.tangent[1] * (x - foot.x)
    assert projection.side == (1 if left >= 0 else -1)
    assert 0.0 <= projection.abscissa <= border.length


DENSE = [border.polyline(0.002) for border in BORDERS]


@pytest.mark.parametrize("border", BORDERS)
def test_projecting_many_equals_projecting_each(border: Border) -> None:
    points = np.random.default_rng(1).uniform(-4.0, 16.0, (300, 2))
    abscissae, distances = border.project_many(points)
    for (x, y), s, distance in zip(points, abscissae, distances, strict=True):
        projection = border.project(x, y)
        assert distance == pytest.approx(projection.distance, abs=1e-12)
        assert abs(border.difference(s, projection.abscissa)) < 1e-9


@given(a=st.floats(-200.0, 200.0), b=st.floats(-200.0, 200.0))
def test_difference_wraps_on_a_closed_border_only(a: float, b: float) -> None:
    length = CLOSED.length
    wrapped = CLOSED.difference(a, b)
    assert -length / 2 <= wrapped < length / 2 + 1e-9
    turns = (a - b - wrapped) / length
    assert turns == pytest.approx(round(turns), abs=1e-9)
    assert OPEN.difference(a, b) == a - b


def test_difference_across_the_seam_is_short() -> None:
    assert CLOSED.difference(0.3, CLOSED.length - 0.2) == pytest.approx(0.5)
    assert CLOSED.difference(CLOSED.length - 0.2, 0.3) == pytest.approx(-0.5)


@given(start=st.integers(0, 5), backwards=st.booleans())
def test_orientation_is_independent_of_the_files_order(start: int, backwards: bool) -> None:
    vertices = L_SHAPE[start:] + L_SHAPE[:start]
    other = round_polygon(vertices[::-1] if backwards else vertices, [1.0] * 6, closed=True)
    reference = round_polygon(L_SHAPE, [1.0] * 6, closed=True)
    assert other.length == pytest.approx(reference.length)
    for s in np.linspace(0.0, reference.length, 40):
        point = reference.at(s)
        same = other.project(point.x, point.y)
        assert same.distance < 1e-9
        assert same.tangent == pytest.approx((point.tx, point.ty), abs=1e-6)


def test_a_closed_border_runs_clockwise_seen_from_above() -> None:
    # At the top of the L (largest y) clockwise is towards +x; the inside is on the right.
    top = CLOSED.project(3.0, 9.5)
    assert top.tangent == pytest.approx((1.0, 0.0))
    assert top.side == 1
    assert CLOSED.project(3.0, 8.5).side == -1
    x, y = CLOSED.polyline(0.01)[:-1].T
    assert np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) < 0.0
    assert all(arc.sweep < 0 for arc in CIRCLE.primitives if isinstance(arc, Arc))
    assert CIRCLE.at(0.0)[:2] == pytest.approx((1 + 3 * math.cos(0.5), 2 + 3 * math.sin(0.5)))


def test_the_same_first_vertex_gives_the_same_zero_either_way_round() -> None:
    forth = round_polygon(L_SHAPE, [1.0] * 6, closed=True)
    back = round_polygon([L_SHAPE[0], *L_SHAPE[:0:-1]], [1.0] * 6, closed=True)
    assert forth.at(0.0)[:2] == pytest.approx((0.0, 1.0))
    for s in (0.0, 7.0, 30.0):
        assert forth.at(s) == pytest.approx(back.at(s))


def test_an_open_border_keeps_the_files_order_and_is_clamped_at_its_ends() -> None:
    assert OPEN.at(0.0)[:2] == pytest.approx((0.0, 0.0))
    assert OPEN.at(OPEN.length)[:2] == pytest.approx((3.0, 9.0))
    assert OPEN.at(-1.0) == OPEN.at(0.0)
    assert OPEN.at(OPEN.length + 1.0) == OPEN.at(OPEN.length)
    before = OPEN.project(-2.0, 0.0)
    assert (before.abscissa, before.distance) == pytest.approx((0.0, 2.0))
    assert before.tangent == pytest.approx((1.0, 0.0))
    assert OPEN.project(2.0, 11.0).abscissa == pytest.approx(OPEN.length)


@pytest.mark.parametrize("border", BORDERS)
def test_length_equals_the_polylines(border: Border) -> None:
    points = border.polyline(0.01)
    steps = np.hypot(*np.diff(points, axis=0).T)
    assert steps.max() <= 0.01 + 1e-9
    assert steps.sum() == pytest.approx(border.length, rel=1e-5)
    assert math.dist(points[0], border.at(0.0)[:2]) < 1e-9
    if border.closed:
        assert math.dist(points[0], points[-1]) < 1e-9


def test_the_previous_branch_is_kept_until_another_is_clearly_nearer() -> None:
    # Half-way between the two long sides of a 4 m wide loop.
    loop = round_polygon([(0, 0), (20, 0), (20, 4), (0, 4)], [1.0] * 4, closed=True)
    low, high = loop.project(10.0, 1.0).abscissa, loop.project(10.0, 3.0).abscissa
    assert loop.project(10.0, 1.995, near=high).abscissa == pytest.approx(high)
    assert loop.project(10.0, 1.995, near=low).abscissa == pytest.approx(low)
    assert loop.project(10.0, 1.98, near=high).abscissa == pytest.approx(low)
    # Far from both: the previous abscissa has no effect.
    assert loop.project(10.0, 1.995, near=0.0).abscissa == pytest.approx(low)


def test_the_branch_is_followed_over_the_seam() -> None:
    loop = round_polygon([(0, 0), (20, 0), (20, 4), (0, 4)], [1.0] * 4, closed=True)
    before = loop.at(loop.length - 0.1)
    after = loop.project(before.x, before.y, near=0.1)
    assert loop.difference(0.1, after.abscissa) == pytest.approx(0.2)


def test_tightest_radius_is_that_of_the_tightest_arc() -> None:
    assert CLOSED.tightest_radius == 0.8
    assert math.isinf(Border([Segment((0, 0), (1, 0))], closed=False).tightest_radius)


@pytest.mark.parametrize(
    ("primitives", "closed", "words"),
    [
        ([], False, ["at least one"]),
        ([Segment((1, 1), (1, 1))], False, ["primitive 1", "no length"]),
        ([Segment((0, 0), (1, 0)), Segment((1.1, 0), (2, 0))], False, ["primitive 1", "0.100 m"]),
        ([Segment((0, 0), (1, 0)), Segment((1, 0), (1, 1))], False, ["primitive 2", "90.0 deg"]),
        ([Segment((0, 0), (1, 0))], True, ["primitive 1", "1.000 m"]),
        ([Arc((0, 0), 1.0, 0.0, 7.0)], False, ["primitive 1", "more than once"]),
        (
            [
                Segment((0, 0), (4, 0)),
                Arc((4, 1), 1.0, -math.pi / 2, 1.5 * math.pi),
                Segment((3, 1), (3, -3)),
            ],
            False,
            ["primitive 1 (segment", "meets primitive 3 (segment"],
        ),
    ],
)
def test_invalid_borders_are_refused_with_the_primitive(
    primitives: list[Segment | Arc], closed: bool, words: list[str]
) -> None:
    with pytest.raises(BorderError) as caught:
        Border(primitives, closed=closed)
    for word in words:
        assert word in str(caught.value)


def test_too_tight_arc_is_refused_with_its_place() -> None:
    CLOSED.require_radius(0.8)
    tight = Border(
        [
            Segment((0.0, 0.0), (3.0, 0.0)),
            Arc((3.0, 0.3), 0.3, -math.pi / 2, math.pi / 2),
            Segment((3.3, 0.3), (3.3, 4.0)),
        ],
        closed=False,
    )
    tight.require_radius(0.3)
    with pytest.raises(BorderError, match=r"primitive 2 \(arc from 3\.000, 0\.000 .* s = 3\.00 m "):
        tight.require_radius(0.31)
