"""Loops against the errors of the way between their ends, and against each other."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np
import pytest

from maps.pose import Pose
from tools.mapping.slam.loop_check import (
    MOST_STRAIN,
    CheckedLoop,
    is_overruled,
    strain,
    worst_bend,
    write_loops,
)
from tools.mapping.slam.pose_graph import Edge
from tools.mapping.slam.way_error import WayError

SIGMAS = (0.02, 0.01, 0.01)  # m, m, rad; of a step
STEP = Pose(0.25, 0.0, math.radians(1.0))
STEPS = 200
LOOP_INFORMATION = np.diag([4e3, 4e3, 6e4])


def chained(steps: list[Pose]) -> list[Pose]:
    poses = [Pose(1.0, -2.0, 0.7)]
    for step in steps:
        poses.append(poses[-1].compose(step))
    return poses


def errors_along(poses: list[Pose]) -> WayError:
    information = np.diag(np.array(SIGMAS) ** -2)
    pairs = enumerate(itertools.pairwise(poses))
    return WayError(poses, [Edge(i, i + 1, a.between(b), information) for i, (a, b) in pairs])


def noisy(rng: np.random.Generator) -> list[Pose]:
    return chained([STEP.compose(Pose(*rng.normal(0.0, SIGMAS))) for _ in range(STEPS)])


def test_covariance_of_a_way_is_that_of_many_noisy_ones() -> None:
    truth, rng = chained([STEP] * STEPS), np.random.default_rng(3)
    start, end = 20, 150
    ends = np.array([way[start].between(way[end]) for way in (noisy(rng) for _ in range(1500))])
    expected = np.cov((ends - truth[start].between(truth[end])).T)
    found = errors_along(truth).between(start, end)
    np.testing.assert_allclose(np.sqrt(np.diag(found)), np.sqrt(np.diag(expected)), rtol=0.1)
    np.testing.assert_allclose(found, expected, atol=0.1 * float(np.max(expected)))


def test_true_loops_are_within_the_errors_of_the_way_and_look_alikes_are_not() -> None:
    truth, rng = chained([STEP] * STEPS), np.random.default_rng(4)
    for _ in range(20):
        drifted = noisy(rng)
        true = Edge(10, 190, truth[10].between(truth[190]), LOOP_INFORMATION)
        assert strain(true, drifted, errors_along(drifted)) < MOST_STRAIN
        beside = Edge(10, 190, true.pose.compose(Pose(0.0, 15.0, 0.0)), LOOP_INFORMATION)
        assert strain(beside, drifted, errors_along(drifted)) > MOST_STRAIN


def test_a_direction_that_scans_do_not_see_is_no_strain() -> None:
    truth = chained([Pose(0.25, 0.0, 0.0)] * STEPS)
    corridor = np.diag([0.0, 4e3, 6e4])
    slid = truth[0].between(truth[100]).compose(Pose(20.0, 0.0, 0.0))
    assert strain(Edge(0, 100, slid, corridor), truth, errors_along(truth)) < 0.1
    assert not is_overruled(Edge(0, 100, slid, corridor), truth)
    assert is_overruled(Edge(0, 100, slid, LOOP_INFORMATION), truth)


def test_a_bend_is_found_where_it_is() -> None:
    truth = chained([STEP] * STEPS)
    errors = errors_along(truth)
    assert worst_bend(truth, truth, errors)[0] == pytest.approx(0.0, abs=1e-6)
    steps = [STEP] * STEPS
    steps[90] = Pose(0.25, 8.0, STEP.theta)
    bend, place = worst_bend(chained(steps), truth, errors)
    assert bend > MOST_STRAIN
    assert abs(place - 90) <= 32


def test_loops_are_written_one_a_line(tmp_path: Path) -> None:
    loop = CheckedLoop(Pose(1.0, 2.0, 0.0), 30.0, 0.5, math.radians(3.0), 1.25, kept=False)
    write_loops(tmp_path / "loops.csv", [loop])
    assert (tmp_path / "loops.csv").read_text().splitlines() == [
        "x_m,y_m,way_m,shift_m,turn_deg,strain,kept",
        "1.000,2.000,30.000,0.500,3.000,1.250,0",
    ]
