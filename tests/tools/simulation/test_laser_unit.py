"""A laser as it is built and mounted."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest

from tools.simulation.laser_unit import LaserUnit
from tools.simulation.truth.robot_truth import LaserTruth
from tools.simulation.truth.truth import load_truth

PLAIN = load_truth("plain").robot.laser
BEARINGS = np.radians(np.linspace(-90.0, 90.0, 181))


def make_unit(**changes: object) -> LaserUnit:
    truth: LaserTruth = msgspec.structs.replace(PLAIN, **changes)
    return LaserUnit(truth, 0.0, np.random.default_rng(1))


def test_a_level_laser_sees_neither_floor_nor_itself() -> None:
    assert make_unit().ends(BEARINGS, 0.0) is None


def test_a_laser_tilted_down_by_a_degree_sees_the_floor_ahead() -> None:
    ends = make_unit(tilt=math.radians(1.0)).ends(BEARINGS, 0.0)
    assert ends is not None
    assert ends[90] == pytest.approx(PLAIN.height / math.radians(1.0))
    assert ends[90] == ends.min()


def test_a_nod_of_the_robot_adds_to_the_tilt() -> None:
    unit = make_unit(tilt=-math.radians(1.0))
    ends = unit.ends(BEARINGS, math.radians(3.0))
    assert ends is not None
    assert ends[90] == pytest.approx(PLAIN.height / math.radians(2.0))


def test_a_mast_in_view_ends_the_beams_that_meet_it() -> None:
    mast = ((0.20, 0.10), (0.23, 0.10), (0.23, 0.13), (0.20, 0.13))
    ends = make_unit(own_parts=(mast,)).ends(BEARINGS, 0.0)
    assert ends is not None
    met = np.isfinite(ends)
    assert 5 < met.sum() < 20
    assert (BEARINGS[met] > 0.0).all()
    assert (ends[met] < 0.3).all()


def test_ranges_are_shifted_stretched_and_quantised() -> None:
    unit = make_unit(offset=0.004, stretch=0.01, quantum=0.01)
    reported = unit.reported(np.array([1.0, 2.0, np.inf]), BEARINGS[:3], 0.0)
    assert reported == pytest.approx([1.01, 2.02, np.inf])


def test_a_dazzled_laser_is_blind_in_a_sector_for_a_while() -> None:
    unit = make_unit(dazzles=0.05)
    blind = [
        int(np.isinf(unit.reported(np.ones(181), BEARINGS, 0.1 * step)).sum())
        for step in range(3000)
    ]
    share = np.count_nonzero(blind) / len(blind)
    assert 0.01 < share < 0.2
    assert max(blind) <= 25


def test_nothing_returns_beyond_the_reach() -> None:
    ranges = make_unit(reach=20.0).reported(np.array([19.9, 20.1]), BEARINGS[:2], 0.0)
    assert ranges.tolist() == [19.9, math.inf]


def test_stuck_beams_report_what_they_had_then() -> None:
    unit = make_unit(stuck_from=10.0, stuck=(-2.0, 0.0))
    bearings = np.array([-1.0, 1.0])
    assert unit.reported(np.array([3.0, 3.0]), bearings, 9.9).tolist() == [3.0, 3.0]
    assert unit.reported(np.array([2.0, 2.0]), bearings, 10.0).tolist() == [2.0, 2.0]
    assert unit.reported(np.array([1.0, 1.0]), bearings, 11.0).tolist() == [2.0, 1.0]
