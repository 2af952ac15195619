"""The watch for own parts, on scans of a square room by a robot that turns in it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from drivers.lms200.measurement import TURN
from drivers.scan import Scan, Special
from maps.pose import Pose
from robot_agent.obstacles.own_parts_watch import OwnPartsWatch

BEAMS = np.radians(np.arange(-90.0, 91.0))
PADDLE = slice(105, 115)
POST = 0.5, math.radians(4.0)  # m, and half its width, rad


def room(heading: float, wall: float = 0.6) -> NDArray[np.float64]:
    """Return (181,) ranges, m, in the middle of a square room; wall: m to each of its walls."""
    to_wall = (BEAMS + heading + math.pi / 4) % (math.pi / 2) - math.pi / 4
    return np.asarray(wall / np.cos(to_wall))


def scan(t: float, ranges: NDArray[np.float64]) -> Scan:
    none = np.zeros(len(ranges), dtype=np.uint8)
    return Scan(t, float(BEAMS[0]), math.radians(1.0), ranges, 0x10, 1, TURN, none, none, None)


def turn(
    watch: OwnPartsWatch,
    *,
    paddle: float | None = None,
    post: bool = False,
    seconds: float = 20.0,
    degrees: float = 40.0,
    radius: float = 0.0,
) -> None:
    """Turn left by some degrees on an arc of a radius, m.

    paddle: m, range of an own part. post: stands before the robot all along, though not its own.
    """
    rng = np.random.default_rng(3)
    for number in range(int(seconds / 0.2)):
        t = 0.2 * number
        heading = math.radians(degrees) * t / seconds
        ranges = room(heading)
        if post:
            seen = np.abs(BEAMS + heading - math.radians(20.0)) < POST[1]
            ranges[seen] = POST[0]
        if paddle is not None:
            ranges[PADDLE] = paddle
        ranges += rng.normal(0.0, 0.005, len(ranges))
        pose = Pose(radius * math.sin(heading), radius * (1.0 - math.cos(heading)), heading)
        watch.update(t, pose, scan(t, ranges))


def test_a_part_that_turns_with_the_robot_is_found_with_its_sector() -> None:
    watch = OwnPartsWatch()
    turn(watch, paddle=0.25)
    ((first, last),) = watch.sectors
    assert (round(math.degrees(first)), round(math.degrees(last))) == (14, 25)
    assert np.allclose(np.hypot(*watch.places.T), 0.25, atol=0.03)


def test_walls_and_posts_beside_a_turning_robot_are_none_of_its_parts() -> None:
    watch = OwnPartsWatch()
    turn(watch, post=True, degrees=360.0)
    assert watch.sectors == ()


def test_neither_an_arc_nor_a_quick_turn_is_evidence() -> None:
    for how in ({"radius": 0.6}, {"seconds": 5.0}, {"degrees": 10.0}):
        watch = OwnPartsWatch()
        turn(watch, paddle=0.25, **how)
        assert watch.sectors == ()


def test_parts_are_kept_until_the_laser_is_opened_again() -> None:
    watch = OwnPartsWatch()
    turn(watch, paddle=0.25)
    turn(watch)
    assert len(watch.sectors) == 1
    watch.restart()
    turn(watch)
    assert watch.sectors == ()


def test_a_wall_cut_by_the_end_of_the_view_and_an_ignored_sector_is_no_part() -> None:
    watch = OwnPartsWatch()
    for number in range(100):  # 20 s, by 40 degrees, along a wall that is always at 0.4 m
        t = 0.2 * number
        ranges = np.full(181, 3.0)
        ranges[:40] = 0.4
        ranges[12:40] = math.inf
        seen = scan(t, ranges)
        seen.specials[12:40] = Special.IGNORED
        watch.update(t, Pose(0.0, 0.0, math.radians(0.4 * number)), seen)
    assert watch.sectors == ()
