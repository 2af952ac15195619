"""Equation 13 with its corrections."""

import math

import pytest

from maps.border import Border
from maps.border_primitives import Arc, Segment
from robot_agent.patrol.neighbor_state import NO_NEIGHBOR, NeighborState
from robot_agent.patrol.settings import PatrolSettings

LINE = Border([Segment((0.0, 0.0), (20.0, 0.0))], closed=False)
# Closed, 20 x 1.5 m with round ends: two stretches nearer than the visibility range.
STADIUM = Border(
    [
        Segment((0.0, 0.0), (20.0, 0.0)),
        Arc((20.0, 0.75), 0.75, -math.pi / 2, math.pi),
        Segment((20.0, 1.5), (0.0, 1.5)),
        Arc((0.0, 0.75), 0.75, math.pi / 2, math.pi),
    ],
    closed=True,
)


def state(border=LINE):
    return NeighborState(PatrolSettings(), border)


def view(position, teammate, border=LINE, judge=None):
    judge = judge or state(border)
    return judge.view(position, border.project(*position), teammate)


@pytest.mark.parametrize(
    ("distance", "magnitude"),
    [(0.0, 1.0), (0.69, 1.0), (0.7, 1.0), (1.35, 0.5), (1.51, 0.49 / 1.3), (2.0, 0.0), (2.3, 0.0)],
)
@pytest.mark.parametrize(("x", "side"), [(9.0, -1), (11.0, 1)])
def test_gamma_by_distance_and_side(distance, magnitude, x, side):
    """Lower abscissa is left and negative, also in the third case that is printed as 1."""
    seen = view((10.0, 0.0), (x, -distance))
    assert seen.gamma == pytest.approx(side * magnitude)
    assert seen.distance == pytest.approx(math.hypot(1.0, distance))


def test_without_a_teammate_distance_is_infinite_and_gamma_zero():
    assert view((10.0, 0.0), None) == NO_NEIGHBOR
    assert math.isinf(NO_NEIGHBOR.distance)
    assert NO_NEIGHBOR.gamma == 0.0


def test_sides_are_right_across_the_seam():
    """On a closed border the higher abscissa may be the smaller number."""
    before, after = STADIUM.at(STADIUM.length - 0.5), STADIUM.at(0.5)
    assert view(before[:2], after[:2], STADIUM).gamma == 1.0
    assert view(after[:2], before[:2], STADIUM).gamma == -1.0


def test_equal_abscissa_keeps_the_last_side():
    judge = state()
    assert view((10.0, 0.0), (10.3, 0.0), judge=judge).gamma == 1.0
    assert view((10.0, 0.0), (9.96, 0.5), judge=judge).gamma == 1.0
    assert view((10.0, 0.0), (9.94, 0.5), judge=judge).gamma == -1.0
    assert view((10.0, 0.0), (10.04, 0.5), judge=judge).gamma == -1.0
    view((10.0, 0.0), None, judge=judge)  # out of sight, forgotten
    assert view((10.0, 0.0), (10.04, 0.5), judge=judge).gamma == 1.0


def test_equal_abscissa_at_first_gives_opposite_sides():
    """Outer robot clockwise (teammate on its left), inner one counter-clockwise."""
    outer, inner = (10.0, 0.6), (10.02, -0.6)  # +s is +x: outside is +y
    assert view(outer, inner).gamma == -1.0
    assert view(inner, outer).gamma == 1.0
    assert view((10.0, -0.2), (10.0, -0.6)).gamma == -1.0
    assert view((10.0, -0.6), (10.0, -0.2)).gamma == 1.0


def test_teammate_on_another_stretch_is_not_patrolling():
    across = view((10.0, 0.0), (10.5, 1.5), STADIUM)
    assert across.gamma == 0.0
    assert across.distance == pytest.approx(math.hypot(0.5, 1.5))
    assert view((10.0, 0.0), (11.5, 0.0), STADIUM).gamma != 0.0


def test_teammate_round_a_bend_counts_up_to_the_detour_allowance():
    """Straight distance 1.5 m across the round end, 1.6 x 1.5 + 1 = 3.4 m of border allowed."""
    assert view((19.7, 0.0), (19.7, 1.5), STADIUM).gamma != 0.0  # 2.96 m along the border
    assert view((19.3, 0.0), (19.3, 1.5), STADIUM).gamma == 0.0  # 3.76 m
