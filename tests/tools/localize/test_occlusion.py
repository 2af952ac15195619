"""Occluded scans for studies: the share asked for, never longer than they were."""

from __future__ import annotations

import numpy as np
import pytest

from maps.pose import Pose
from tools.localize.occlusion import NEAREST, PERSON_REACH, Occlusion
from tools.logs.log_step import LogStep

BEARINGS = np.radians(np.arange(-90.0, 91.0))
ROOM = 5.0 * np.column_stack((np.cos(BEARINGS), np.sin(BEARINGS)))


def steps(count: int = 20) -> list[LogStep]:
    nowhere = Pose(0.0, 0.0, 0.0)
    return [LogStep(float(n), nowhere, ROOM, nowhere) for n in range(count)]


def lengths(occluded: list[LogStep]) -> np.ndarray:
    return np.array([np.hypot(*step.points.T) for step in occluded])


@pytest.mark.parametrize("by_people", [False, True])
@pytest.mark.parametrize("share", [0.2, 0.4, 0.6])
def test_the_share_asked_for_ends_short_along_the_same_beams(share: float, by_people: bool) -> None:
    occluded = Occlusion(share, by_people).of(steps())
    found = lengths(occluded)
    assert np.mean(found < 4.999) == pytest.approx(share, abs=0.1)
    assert found.min() >= NEAREST
    assert found.max() <= 5.0 + 1e-9
    for step in occluded:
        np.testing.assert_allclose(np.arctan2(*step.points.T[::-1]), BEARINGS, atol=1e-9)


def test_people_stand_close_over_neighbouring_beams() -> None:
    found = lengths(Occlusion(0.4, by_people=True).of(steps()))
    near = found[found < 4.999]
    assert near.min() >= PERSON_REACH[0]
    assert near.max() <= PERSON_REACH[1]
    alone = (found[:, 1:-1] < 4.999) & (found[:, :-2] > 4.999) & (found[:, 2:] > 4.999)
    assert alone.mean() < 0.01


def test_scans_differ_and_are_the_same_again() -> None:
    first, again = (Occlusion(0.4, by_people=True).of(steps()) for _ in range(2))
    np.testing.assert_array_equal(first[3].points, again[3].points)
    assert not np.array_equal(first[3].points, first[4].points)
