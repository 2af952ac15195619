"""Doorsills and slopes."""

from __future__ import annotations

import math
from pathlib import Path

import msgspec
import numpy as np
import pytest

from maps.map_folder import load_map_folder
from maps.pose import Pose
from robot_agent.config import find_map
from tools.simulation.truth.truth import load_truth
from tools.simulation.uneven_floor import UnevenFloor
from tools.simulation.world import World

FOLDER = load_map_folder(find_map("paper_lab", Path()))
TRUTH = msgspec.structs.replace(load_truth("rough").floor, sills=2, slopes=1)


def make_floor() -> UnevenFloor:
    assert FOLDER.border is not None
    return UnevenFloor(FOLDER.map, FOLDER.border, TRUTH, np.random.default_rng(1))


def places(floor: UnevenFloor) -> dict[int, Pose]:
    """Return a pose along the border on each patch."""
    assert FOLDER.border is not None
    found: dict[int, Pose] = {}
    for s in np.arange(0.0, FOLDER.border.length, 0.02).tolist():
        point = FOLDER.border.at(s)
        pose = Pose(point.x, point.y, math.atan2(point.ty, point.tx))
        found.setdefault(floor.number_at(pose), pose)
    return found


def test_all_sills_and_slopes_lie_on_the_border() -> None:
    floor = make_floor()
    assert sorted(places(floor)) == [0, 1, 2, 3]
    assert sum(floor.is_sill(number) for number in (1, 2, 3)) == 2


def test_a_robot_nods_the_other_way_when_it_comes_from_the_other_side() -> None:
    floor = make_floor()
    for number, pose in places(floor).items():
        there, back = (floor.pitch(number, pose.theta + turn) for turn in (0.0, math.pi))
        assert there == pytest.approx(-back)
        assert (abs(there) > 0.005) == (number > 0)


def test_a_doorsill_turns_the_robot_once_and_its_wheels_do_not_know() -> None:
    floor = make_floor()
    pose = next(pose for number, pose in places(floor).items() if floor.is_sill(number))
    world = World(FOLDER.map, np.random.default_rng(1), load_truth("ideal").noise, floor=floor)
    body = world.add_body(pose.compose(Pose(-0.2, 0.0, 0.0)))
    headings, counted = [], 0.0
    for _ in range(40):
        counted += world.move(body, 0.01, 0.0).odometer_rotation
        headings.append(body.pose.theta)
    assert counted == pytest.approx(0.0)
    assert len(set(np.round(headings, 9))) == 2
