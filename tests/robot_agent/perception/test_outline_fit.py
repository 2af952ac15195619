"""Fit of a Pioneer's outline to laser points."""

from __future__ import annotations

import math

import numpy as np
import pytest

from maps.pose import Pose
from robot_agent.perception.outline_fit import (
    SightEdge,
    fit_outlines,
)
from robot_agent.perception.segments import Segment, find_segments
from robot_agent.perception.settings import PerceptionSettings
from robot_agent.perception.unexplained import UnexplainedPoints
from tests.robot_agent.perception.simulated_room import SILHOUETTES, Box, Room

SETTINGS = PerceptionSettings()
HERE = Pose(3.0, 4.0, 0.2)


def seen(room: Room, box: Box, rng: np.random.Generator) -> Segment:
    """Return the nearest segment of a scan of a room with one body."""
    points = room.scan(HERE, [box], rng)
    ranges = np.hypot(points[:, 0], points[:, 1])
    mask = UnexplainedPoints(room.map, SETTINGS.detection_range).mask(HERE, points, ranges)
    return find_segments(SILHOUETTES, points, ranges, mask)[0]


def body(rng: np.random.Generator, *size: float) -> Box:
    """Return a body of a size at a drawn place in view, at a drawn heading."""
    distance, bearing = rng.uniform(0.8, 2.5), HERE.theta + rng.uniform(-1.0, 1.0)
    return Box(
        HERE.x + distance * math.cos(bearing),
        HERE.y + distance * math.sin(bearing),
        rng.uniform(-math.pi, math.pi),
        *size,
    )


def test_centres_are_right_within_their_covariances(room: Room) -> None:
    rng = np.random.default_rng(11)
    errors, squared = [], []
    for _ in range(200):
        box = body(rng)
        segment = seen(room, box, rng)
        truth = HERE.between(Pose(box.x, box.y, 0.0))
        off = np.array((segment.x - truth.x, segment.y - truth.y))
        covariance = np.array(((segment.var_x, segment.cov_xy), (segment.cov_xy, segment.var_y)))
        errors.append(float(np.hypot(*off)))
        squared.append(float(off @ np.linalg.solve(covariance, off)))
    assert np.percentile(errors, 95) < 0.045
    assert abs(np.mean(errors)) < 0.02
    inside = np.mean(np.array(squared) < 5.99)  # the 95 % ellipse
    assert inside > 0.93
    assert np.mean(squared) > 0.2, "and not far too wide"


def test_other_objects_as_large_as_a_robot_have_a_larger_misfit(room: Room) -> None:
    rng = np.random.default_rng(12)
    misfits = {
        size: np.array([seen(room, body(rng, *size), rng).misfit for _ in range(120)])
        for size in ((0.511, 0.425), (0.7, 0.6), (0.35, 0.35))
    }
    robots = misfits.pop((0.511, 0.425))
    assert np.percentile(robots, 95) < 0.6
    for others in misfits.values():
        assert np.mean(others < 0.6) < 0.4
        assert np.median(others) > 2.0 * np.median(robots)


def test_grazed_side_is_not_taken_as_an_edge(room: Room) -> None:
    """Beams along a side are so far apart that the segment ends, though the side continues."""
    rng = np.random.default_rng(13)
    for theta in np.radians((3.0, 5.0, 8.0, 11.0)).tolist():
        box = Box(HERE.x + 2.3, HERE.y + 0.1, theta)
        segment = seen(room, box, rng)
        truth = HERE.between(Pose(box.x, box.y, 0.0))
        assert segment.misfit < 0.8
        assert math.hypot(segment.x - truth.x, segment.y - truth.y) < 0.06


def test_fewer_visible_edges_give_a_larger_covariance_along_a_side() -> None:
    # The middle of the rear end of a robot that drives away, straight ahead; edges at its sides.
    rear = np.column_stack((np.full(9, 2.0), np.linspace(-0.1, 0.1, 9)))
    both = (SightEdge(0.0, 1.0, 0.2125, 0.02), SightEdge(0.0, -1.0, 0.2125, 0.02))
    fits = [
        fit_outlines(SILHOUETTES, [rear], [(2.2, 0.1)], [both[:edges]])[0] for edges in (0, 1, 2)
    ]
    none, one, two = (math.sqrt(fit.var_y) for fit in fits)
    assert none > 0.07
    assert none > 2.0 * one
    assert one > two
    assert fits[2].x == pytest.approx(2.0 + 0.2555, abs=0.02)
    assert fits[2].y == pytest.approx(0.0, abs=0.02)


def test_segments_are_fitted_independently() -> None:
    rng = np.random.default_rng(14)
    parts = [
        np.column_stack((np.full(n, x), np.linspace(-0.2, 0.2, n))) + rng.normal(0, 0.01, (n, 2))
        for n, x in ((9, 1.0), (31, 2.0), (3, 3.0))
    ]
    centres = [(1.25, 0.0), (2.25, 0.0), (3.25, 0.0)]
    edges = [(SightEdge(0.0, 1.0, 0.21, 0.02),), (), (SightEdge(0.0, -1.0, 0.21, 0.02),)]
    together = fit_outlines(SILHOUETTES, parts, centres, edges)
    alone = [
        fit_outlines(SILHOUETTES, [part], [centre], [own])[0]
        for part, centre, own in zip(parts, centres, edges, strict=True)
    ]
    for one, other in zip(together, alone, strict=True):
        assert (one.x, one.y, one.misfit) == pytest.approx((other.x, other.y, other.misfit))


def test_no_segments_give_no_fits() -> None:
    assert fit_outlines(SILHOUETTES, [], [], []) == []
