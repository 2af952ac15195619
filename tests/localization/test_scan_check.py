"""One scan against the map at one pose: fit, dynamic end points, beams that cross walls."""

from __future__ import annotations

import numpy as np
import pytest

from localization.distance_surface import DistanceSurface
from localization.scan_check import ScanCheck
from maps.pose import Pose

TRUTH = Pose(3.0, 2.0, 0.4)


@pytest.fixture
def check(room) -> ScanCheck:
    return ScanCheck(room.map, DistanceSurface(room.map))


def test_fit_falls_with_the_distance_from_the_truth(room, check: ScanCheck) -> None:
    points = room.scan(TRUTH)
    fits = [
        check.fit(Pose(TRUTH.x + off, TRUTH.y + off, TRUTH.theta), points).whole
        for off in (0.0, 0.1, 0.3, 1.0)
    ]
    assert fits[0] > 0.95
    assert fits[:3] == sorted(fits[:3], reverse=True)
    assert fits[-1] < 0.35


def test_too_few_points_give_none(room, check: ScanCheck) -> None:
    points = room.scan(TRUTH)[:9]
    assert check.fit(TRUTH, points) is None
    assert check.wall_crossing(TRUTH, points) == 0.0


def test_people_are_left_out_of_the_fit_up_to_a_share_of_the_beams(room, check: ScanCheck) -> None:
    points = room.scan(TRUTH)
    some, many = points.copy(), points.copy()
    some[40:95] *= 0.5  # 30 %
    many[2:160] *= 0.7  # 87 %
    fit = check.fit(TRUTH, some)
    assert fit.whole == pytest.approx(0.7, abs=0.05)
    assert fit.fit_without_dynamic > 0.95
    assert fit.beside > 0.95
    assert check.fit(TRUTH, many).fit_without_dynamic < 0.65


def test_crowd_round_the_robot_is_left_out_if_what_is_seen_beside_it_fits(
    room, check: ScanCheck
) -> None:
    points = room.scan(TRUTH)
    points[20:140] *= 0.5  # 66 %
    fit = check.fit(TRUTH, points)
    assert fit.whole < 0.4
    assert fit.fit_without_dynamic > 0.9
    elsewhere = Pose(TRUTH.x + 0.5, TRUTH.y + 0.6, TRUTH.theta + 0.5)
    assert check.fit(elsewhere, points).fit_without_dynamic < 0.5
    assert check.fit(elsewhere, points).beside < 0.6


def test_reading_behind_a_mapped_wall_is_no_person(room, check: ScanCheck) -> None:
    """Another room's floor may lie there, on which an end point is none the less wrong."""
    points = room.scan(TRUTH)
    length = np.linalg.norm(points, axis=1, keepdims=True)
    assert not check.short(TRUTH, points).any()
    assert check.short(TRUTH, 0.5 * points).mean() > 0.9
    assert not check.short(TRUTH, points * (1.0 + 0.45 / length)).any()


def test_beams_beyond_the_mapped_floor_are_not_left_out(room, check: ScanCheck) -> None:
    """End points outside the map, in unknown cells, are not people on the floor."""
    points = room.scan(TRUTH)
    points[40:95] *= 20.0
    fit = check.fit(TRUTH, points)
    assert fit.whole == pytest.approx(fit.fit_without_dynamic)


def test_people_do_not_make_beams_end_behind_walls(room, check: ScanCheck) -> None:
    points = room.scan(TRUTH)
    length = np.linalg.norm(points, axis=1, keepdims=True)
    assert check.fit(TRUTH, points).through == 0.0
    assert check.fit(TRUTH, points * (1.0 - 0.2 / length)).through == 0.0  # people close to walls
    points[40:95] *= 1.0 + 0.5 / length[40:95]  # 30 %
    assert 0.2 < check.fit(TRUTH, points).through < 0.35  # some graze a wall


def test_beam_through_a_wall_is_less_likely_than_one_that_ends_on_a_person(
    room, check: ScanCheck
) -> None:
    points = room.scan(TRUTH)
    length = np.linalg.norm(points, axis=1, keepdims=True)
    person, behind = points.copy(), points.copy()
    person[40:95] *= 0.6
    behind[40:95] *= 1.0 + 0.6 / length[40:95]
    whole, some, wrong = (check.log_likelihood(TRUTH, each) for each in (points, person, behind))
    assert whole == pytest.approx(0.0, abs=0.1)
    assert some == pytest.approx(whole + 0.3 * np.log(0.1), abs=0.1)
    assert wrong == pytest.approx(whole + 0.3 * np.log(0.01), abs=0.2)
    assert check.log_likelihood(TRUTH, points[:0]) == 0.0


def test_at_the_true_pose_no_beam_crosses_walls(room, check: ScanCheck) -> None:
    assert check.wall_crossing(TRUTH, room.scan(TRUTH)) == 0.0
    assert check.wall_crossing(TRUTH, 0.5 * room.scan(TRUTH)) == 0.0


def test_share_of_beams_that_cross_a_wall(room, check: ScanCheck) -> None:
    """Beams of 3 m to either side, of a robot that stands 1 m before a wall and looks along it."""
    pose = Pose(3.5, 1.0, 0.0)
    angles = np.concatenate((np.full(30, -np.pi / 2), np.full(30, np.pi / 2)))
    points = np.column_stack((3.0 * np.cos(angles), 3.0 * np.sin(angles)))
    assert check.wall_crossing(pose, points) == pytest.approx(0.5, abs=0.02)


def test_beam_that_ends_just_behind_a_wall_does_not_cross_it(room, check: ScanCheck) -> None:
    points = room.scan(TRUTH)
    length = np.linalg.norm(points, axis=1, keepdims=True)
    assert check.wall_crossing(TRUTH, points * (1.0 + 0.1 / length)) == 0.0
    assert check.wall_crossing(TRUTH, points * (1.0 + 1.0 / length)) > 0.9


def with_board(points, ahead: float = 0.6, half_width: float = 0.7):
    """End points of a scan with a flat board across the robot's way."""
    bearing = np.arctan2(points[:, 1], points[:, 0])
    on_board = (np.abs(np.tan(bearing)) * ahead < half_width) & (np.abs(bearing) < 1.5)
    changed = points.copy()
    changed[on_board, 0] = ahead
    changed[on_board, 1] = ahead * np.tan(bearing[on_board])
    return changed, on_board


def test_large_occluder_is_found(room, check: ScanCheck) -> None:
    points, on_board = with_board(room.scan(TRUTH))
    hiding = check.hiding(TRUTH, points)
    assert hiding is not None
    assert hiding.tolist() == on_board.tolist()


def test_small_or_distant_or_no_object_is_no_occluder(room, check: ScanCheck) -> None:
    scan = room.scan(TRUTH)
    assert check.hiding(TRUTH, scan) is None
    assert check.hiding(TRUTH, with_board(scan, half_width=0.2)[0]) is None
    assert check.hiding(TRUTH, with_board(scan, ahead=1.6, half_width=1.5)[0]) is None


def test_no_occluder_if_the_rest_of_the_scan_does_not_fit(room, check: ScanCheck) -> None:
    points, _ = with_board(room.scan(TRUTH))
    elsewhere = Pose(TRUTH.x + 0.5, TRUTH.y + 0.6, TRUTH.theta + 0.5)
    assert check.hiding(elsewhere, points) is None
    blocked, _ = with_board(room.scan(TRUTH), half_width=9.0)
    assert check.hiding(TRUTH, blocked) is None  # nothing is seen beside it
