"""Projection of scans to base_link; an asymmetric scene reveals mirrored or rotated geometry."""

import math
from dataclasses import replace

import numpy as np
import pytest

from drivers.lms200.measurement import TURN
from drivers.scan import Scan, beam_time_offsets
from maps.pose import Pose
from robot_agent.motion.footprint import Footprint
from robot_agent.motion.gate_limits import GateLimits
from robot_agent.obstacles.latest_scan import REACH, Obstacles
from robot_agent.perception.scan_points import ScanProjector, move_points


def scan_of(ranges: list[float], increment: float = math.pi / 2) -> Scan:
    return Scan(
        t=0.0,
        angle_min=-math.pi / 2,
        angle_increment=increment,
        ranges=np.array(ranges),
        status=0x10,
        turns=1,
        turn_time=TURN,
        specials=np.zeros(len(ranges), np.uint8),
        flags=np.zeros(len(ranges), np.uint8),
        reflectors=None,
    )


def test_points_follow_the_axes_of_rep_103() -> None:
    points = ScanProjector(Pose(0.0, 0.0, 0.0)).points(scan_of([1.0, 2.0, 3.0]))
    assert points == pytest.approx(np.array([(0.0, -1.0), (2.0, 0.0), (0.0, 3.0)]))


def test_the_mount_moves_and_turns_the_points() -> None:
    points = ScanProjector(Pose(0.1, 0.2, math.pi / 2)).points(scan_of([1.0, 2.0, 3.0]))
    assert points == pytest.approx(np.array([(1.1, 0.2), (0.1, 2.2), (-2.9, 0.2)]))


def test_beams_without_return_are_left_out() -> None:
    projector = ScanProjector(Pose(0.0, 0.0, 0.0))
    assert projector.points(scan_of([math.inf, 2.0, math.inf])) == pytest.approx(
        np.array([(2.0, 0.0)])
    )
    assert projector.points(scan_of([math.inf] * 3)).shape == (0, 2)


def test_change_of_scan_geometry_updates_directions() -> None:
    projector = ScanProjector(Pose(0.0, 0.0, 0.0))
    projector.points(scan_of([1.0, 1.0, 1.0]))
    finer = projector.points(scan_of([1.0] * 5, math.pi / 4))
    assert finer[1] == pytest.approx((math.sqrt(0.5), -math.sqrt(0.5)))


def test_ignored_sector_is_out_of_view() -> None:
    projector = ScanProjector(Pose(0.0, 0.0, 0.0), ignored=[(0.2, 0.4), (1.2, 2.0)])
    projector.points(scan_of([1.0, 1.0, 1.0]))
    places = np.array([(math.cos(a), math.sin(a)) for a in (0.1, 0.3, 0.5, 1.1, 1.3, -1.5)])
    assert projector.in_view(places).tolist() == [True, False, True, True, False, True]


def test_returns_from_inside_the_footprint_are_none() -> None:
    footprint = Footprint(GateLimits(front=0.5, rear=0.3, half_width=0.2))
    projector = ScanProjector(Pose(0.1, 0.0, 0.0), footprint=footprint)
    own = scan_of([0.1, 0.3, 0.1])
    assert np.isinf(projector.without_body(own).ranges).all()
    outside = scan_of([0.21, 0.41, math.inf])
    assert projector.without_body(outside) is outside
    assert ScanProjector(Pose(0.1, 0.0, 0.0)).without_body(own) is own, "no footprint"


def test_something_that_touches_the_body_is_kept() -> None:
    footprint = Footprint(GateLimits(front=0.5, rear=0.3, half_width=0.2))
    projector = ScanProjector(Pose(0.1, 0.0, 0.0), footprint=footprint)
    assert projector.without_body(scan_of([0.18, 0.38, 0.18])).ranges == pytest.approx(
        [0.18, 0.38, 0.18]
    )


def test_view_is_between_the_outermost_beams() -> None:
    projector = ScanProjector(Pose(0.1, 0.0, math.pi))  # looks back
    places = np.array([(0.0, 0.5), (0.2, 0.5), (-3.0, 0.0), (3.0, 0.0), (0.0, -0.5)])
    assert not projector.in_view(places).any(), "nothing before the first scan"
    projector.points(scan_of([1.0, 1.0, 1.0]))
    assert projector.in_view(places).tolist() == [True, False, True, False, True]


def test_a_beam_without_a_return_has_measured_nothing() -> None:
    projector = ScanProjector(Pose(0.1, 0.0, math.pi))  # looks back
    places = np.array([(0.1, 0.5), (0.0, 0.0), (-0.3, 0.1), (0.1, -0.5), (0.6, 0.0)])
    projector.points(scan_of([1.0, 1.0, 1.0]))
    assert projector.has_measured(places).tolist() == [True, True, True, True, False]
    projector.points(scan_of([1.0, math.inf, 1.0]))
    assert projector.has_measured(places).tolist() == [True, False, False, True, False]


def test_how_far_beams_go_beyond_a_place() -> None:
    projector = ScanProjector(Pose(0.1, 0.0, 0.0))
    places = np.array([(0.6, 0.0), (0.1, 0.5), (0.0, 0.5), (0.6, 0.0)])
    assert np.isneginf(projector.goes_beyond(places, 0.0)).all(), "nothing before the first scan"
    ranges = np.full(181, 2.0)
    ranges[[84, 100]] = 0.4, math.inf  # 6 degrees to the right, 10 to the left
    projector.points(scan_of(ranges, math.radians(1.0)))
    inf = math.inf
    assert projector.goes_beyond(places, 0.0) == pytest.approx([1.5, 1.5, -inf, 1.5], abs=1e-6)
    # 0.04 m are 4.6 degrees there, 0.06 m 6.9 and 0.1 m 11.5.
    assert projector.goes_beyond(places[:1], 0.04) == pytest.approx(1.5)
    assert projector.goes_beyond(places[:1], 0.06) == pytest.approx(-0.1)
    assert projector.goes_beyond(places[:1], 0.1) == pytest.approx(-inf)
    assert projector.goes_beyond(places[1:2], 0.1) == pytest.approx(-inf), "partly out of view"
    assert projector.goes_beyond(np.array([(0.1, 0.0)]), 0.0) == pytest.approx(2.0), "at the laser"


def test_beam_delays_follow_the_mirror() -> None:
    delays = beam_time_offsets(181, -math.pi / 2, math.radians(1.0), 1, TURN)
    assert delays[90] == pytest.approx(0.0, abs=1e-12)
    assert (delays[0], delays[180]) == pytest.approx((-TURN / 4, TURN / 4))
    interlaced = beam_time_offsets(361, -math.pi / 2, math.radians(0.5), 2, TURN)
    assert interlaced[1::2].mean() - interlaced[0::2].mean() == pytest.approx(TURN)
    assert interlaced.mean() == pytest.approx(0.0, abs=TURN / 300)


@pytest.mark.parametrize("increment", [1.0, 0.5])
def test_a_wall_seen_while_turning_at_1_rad_per_s_does_not_smear(increment: float) -> None:
    """A wall 3 m ahead, each beam measured from the robot's pose at the beam's own time."""
    v, w, base_from_laser = 0.3, 1.0, Pose(0.15, 0.0, 0.0)
    n = round(180.0 / increment) + 1
    step = math.radians(increment)
    bearings = -math.pi / 2 + step * np.arange(n)
    ranges = np.full(n, math.inf)
    turns = round(1.0 / increment)
    for index, delay in enumerate(beam_time_offsets(n, -math.pi / 2, step, turns, TURN)):
        turn = w * delay
        travel = v * delay
        moved = Pose(travel * math.cos(turn / 2), travel * math.sin(turn / 2), turn)
        laser = moved.compose(base_from_laser)
        along = math.cos(laser.theta + bearings[index])
        if along > 0.5:
            ranges[index] = (3.0 - laser.x) / along
    scan = replace(scan_of(ranges.tolist(), step), turns=turns)
    projector = ScanProjector(base_from_laser)
    assert np.abs(projector.points(scan, v, w)[:, 0] - 3.0).max() < 1e-6
    assert np.abs(projector.points(scan)[:, 0] - 3.0).max() > 0.008


def test_points_move_with_their_frame() -> None:
    moved = move_points(np.array([(1.0, 0.0)]), Pose(2.0, 3.0, math.pi / 2))
    assert moved == pytest.approx(np.array([(2.0, 4.0)]))


def test_obstacles_come_nearer_as_the_robot_drives_on() -> None:
    obstacles = Obstacles()
    assert obstacles.seen_at is None
    obstacles.update(1.0, Pose(0.0, 0.0, 0.0), np.array([(1.0, 0.0), (REACH + 1.0, 0.0)]))
    assert obstacles.seen_at == 1.0
    around = obstacles.around(Pose(0.4, 0.0, math.pi / 2))
    assert around == pytest.approx(np.array([(0.0, -0.6)])), "the far point is dropped"
