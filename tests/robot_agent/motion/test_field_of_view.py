from __future__ import annotations

import math

import numpy as np
import pytest

from robot_agent.motion.field_of_view import FieldOfView, are_covered

AHEAD = FieldOfView(0.1, 0.0, 0.0, math.radians(30.0), 2.0)
BEHIND = FieldOfView(-0.1, 0.0, math.pi, math.radians(30.0), 2.0)


@pytest.mark.parametrize(
    ("x", "y", "covered"),
    [
        (1.0, 0.0, True),
        (0.1, 0.0, True),  # the apex itself
        (1.1, 0.57, True),
        (1.1, 0.58, False),  # beside the sector
        (1.1, -0.57, True),
        (1.1, -0.58, False),
        (2.09, 0.0, True),
        (2.11, 0.0, False),  # beyond its reach
        (-1.0, 0.0, False),
    ],
)
def test_sector_covers_what_is_within_its_angle_and_reach(
    x: float, y: float, covered: bool
) -> None:
    assert AHEAD.covers(x, y) is covered
    assert AHEAD.mask(np.array([(x, y)])).tolist() == [covered]


@pytest.mark.parametrize("y", [-0.01, 0.0, 0.01])
def test_sector_about_the_rear_has_no_seam_at_half_a_turn(y: float) -> None:
    assert BEHIND.covers(-1.0, y)
    assert BEHIND.mask(np.array([(-1.0, y)])).all()


def test_each_position_must_be_in_one_of_several_fields_of_view() -> None:
    assert are_covered([(-1.0, 0.0)], (AHEAD, BEHIND))
    assert not are_covered([(-1.0, 0.0)], (AHEAD,))
    assert not are_covered([(1.0, 0.0)], ())
    assert are_covered([(1.0, 0.0), (-1.0, 0.0)], (AHEAD, BEHIND))
    assert not are_covered([(1.0, 0.0), (0.0, 1.0)], (AHEAD, BEHIND))
