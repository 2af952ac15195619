"""Learning a teammate's silhouette from a recording of a turn in place."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from maps.pose import Pose
from robot_agent.perception.silhouette import Silhouette, Silhouettes
from tests.robot_agent.perception.simulated_room import SILHOUETTES, Box, Room
from tools.calibration.color_calibration import CalibrationError
from tools.calibration.teammate_calibration import learn_silhouette, standing_scans

PERIOD = 0.1  # s
Scans = list[tuple[float, Pose, NDArray[np.float64]]]


def turning(
    length: float, width: float, behind: float, rate: float = 0.4, duration: float = 18.0
) -> Scans:
    """Return the scans of a standing robot before which a box turns about an axis in it.

    behind: m from the axis to the box's middle; rate: rad/s, which varies a little.
    """
    room, rng = Room(), np.random.default_rng(21)
    scans = []
    for step in range(round(duration / PERIOD)):
        t = PERIOD * step
        theta = rate * t + 0.1 * math.sin(0.7 * t)
        x, y = 7.5 - behind * math.cos(theta), 4.2 - behind * math.sin(theta)
        points = room.scan(
            Pose(6.0, 4.0, 0.1), [Box(x, y, theta, length, width)], rng, math.radians(0.5)
        )
        scans.append((t, Pose(1.0, 2.0, 0.3), points))
    return scans


@pytest.mark.parametrize(
    ("length", "width", "behind", "rate"),
    [(0.511, 0.425, 0.046, 0.4), (0.156, 0.155, -0.017, 0.4), (0.626, 0.497, 0.03, -0.6)],
)
def test_widths_are_learned_within_four_centimetres(
    length: float, width: float, behind: float, rate: float
) -> None:
    learned = learn_silhouette(standing_scans(turning(length, width, behind, rate)))
    shape = Silhouette.of(learned.corners)
    assert shape.widths.min() == pytest.approx(min(length, width), abs=0.04)
    assert shape.widths.max() == pytest.approx(math.hypot(length, width), abs=0.05)
    assert learned.rms < 0.012, "the noise of the ranges is 0.01 m"
    assert math.isnan(learned.before), "nothing was admitted before"


def test_a_body_that_none_admitted_resembles_is_told_by_the_residuals() -> None:
    scans = standing_scans(turning(0.626, 0.497, 0.03))
    learned = learn_silhouette(scans, SILHOUETTES.shapes)
    assert learned.before > 2.0 * learned.rms
    assert len(Silhouettes([Silhouette.of(learned.corners)]).shapes) == 1


def test_half_a_turn_is_refused_with_what_was_seen() -> None:
    scans = standing_scans(turning(0.511, 0.425, 0.046, duration=8.0))
    with pytest.raises(CalibrationError, match=r"turned \d+ degrees.*once round"):
        learn_silhouette(scans)


def test_an_empty_room_and_a_short_stand_are_refused() -> None:
    room, rng = Room(), np.random.default_rng(22)
    empty = [(PERIOD * n, Pose(0, 0, 0), room.scan(Pose(6, 4, 0), [], rng)) for n in range(60)]
    with pytest.raises(CalibrationError, match="nothing stands alone within"):
        learn_silhouette(standing_scans(empty))
    with pytest.raises(CalibrationError, match="stood for 20 scans"):
        learn_silhouette(standing_scans(empty[:20]))


def test_only_the_longest_stand_is_used() -> None:
    scans = [(0.1 * n, Pose(0.01 * max(n - 50, 0), 0.0, 0.0), np.ones((3, 2))) for n in range(80)]
    assert len(standing_scans(scans)) == 54
