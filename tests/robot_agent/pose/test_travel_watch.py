"""The watch of travel on scans of a room, ray-cast for a robot whose laser sits otherwise."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from maps.pose import Pose
from robot_agent.pose.travel_scale import TOLERANCE, TravelScale
from robot_agent.pose.travel_watch import TravelFault, TravelWatch

ROOM = np.array(
    [
        (-3.0, -2.0, 5.0, -2.0),
        (5.0, -2.0, 5.0, 3.0),
        (5.0, 3.0, 1.0, 3.0),
        (1.0, 3.0, 1.0, 2.2),
        (1.0, 2.2, -3.0, 2.2),
        (-3.0, 2.2, -3.0, -2.0),
        (3.0, -2.0, 3.0, -1.4),
        (3.0, -1.4, 5.0, -1.4),
    ]
)
"""(n, 4) walls: x, y of both ends, m."""
CORRIDOR = np.array([(-50.0, -1.0, 50.0, -1.0), (-50.0, 1.0, 50.0, 1.0)])
DOORS = np.array(
    [
        (x, side * y, x + length, side * end)
        for x in np.arange(-20.0, 40.0, 5.0)
        for side in (-1.0, 1.0)
        for length, y, end in ((4.0, 1.3, 1.3), (0.0, 1.3, 1.8), (1.0, 1.8, 1.8))
    ]
)
"""A corridor with doors set back in its walls."""
ANGLES = np.radians(np.arange(-90.0, 91.0))
NOISE = 0.01  # m
LASER = Pose(0.1, 0.0, 0.0)


def cast(laser: Pose, walls: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    """Return (181,) ranges, m; inf beyond 30 m."""
    directions = np.exp(1j * (laser.theta + ANGLES))[:, None]
    start = walls[:, 0] + 1j * walls[:, 1] - complex(laser.x, laser.y)
    along = walls[:, 2] + 1j * walls[:, 3] - (walls[:, 0] + 1j * walls[:, 1])
    cross = (directions.conj() * along).imag
    with np.errstate(divide="ignore", invalid="ignore"):
        ranges = (start.conj() * along).imag / cross
        place = (start.conj() * directions).imag / cross
    ranges[(ranges <= 0.0) | (place < 0.0) | (place > 1.0) | ~np.isfinite(ranges)] = np.inf
    nearest = ranges.min(axis=1) + rng.normal(0.0, NOISE, len(ANGLES))
    nearest[nearest > 30.0] = np.inf
    return np.asarray(nearest)


def drive(
    watch: TravelWatch,
    *,
    mount: Pose = LASER,
    mirrored: bool = False,
    walls: NDArray[np.float64] = ROOM,
    repeats: bool = False,
    bend: float = 0.15,
    slip: float = 0.0,
    turned_at: int | None = None,
    metres: float = 2.0,
    scaled: float = 1.0,
    floor: float = math.inf,
) -> float | None:
    """Drive on an arc; return the way, m, at which the watch found a fault, None if it did not.

    mount: how the laser really sits; the watch is told LASER. bend: 1/m. slip: share of the counted
    way that is not driven. turned_at: number of the only scan that is of another place. scaled:
    ranges over true ones. floor: way ahead, m, at which a tilted scanner meets it.
    """
    rng = np.random.default_rng(4)
    true, counted, first = Pose(-1.5, 0.1, 0.0), Pose(0.0, 0.0, 0.3), None
    for number in range(round(metres / 0.05)):
        seen_from = true if number != turned_at else true.compose(Pose(0.1, 0.1, 0.2))
        ranges = cast(seen_from.compose(mount), walls, rng)
        ranges = np.minimum(ranges, floor / np.maximum(np.cos(ANGLES), 1e-3) + rng.normal(0, 0.01))
        if repeats:
            first = ranges if first is None else first
            ranges = first + rng.normal(0.0, NOISE, len(ANGLES))
        ranges = scaled * (ranges[::-1] if mirrored else ranges)
        hit = np.isfinite(ranges)
        ends = ranges[hit] * np.exp(1j * ANGLES[hit]) + LASER.x
        watch.update(0.2 * number, counted, np.column_stack((ends.real, ends.imag)))
        if watch.fault is not None:
            return 0.05 * number
        step = Pose(0.05, 0.0, 0.05 * bend)
        counted = counted.compose(step)
        true = true.compose(step._replace(x=step.x * (1.0 - slip)))
    return None


def spin(watch: TravelWatch, *, mirrored: bool) -> float | None:
    """Turn in place; return the angle, degrees, at which the watch found a fault."""
    rng = np.random.default_rng(4)
    for number in range(40):
        heading = math.radians(4.0 * number)
        ranges = cast(Pose(0.0, 0.0, heading).compose(LASER), ROOM, rng)
        ranges = ranges[::-1] if mirrored else ranges
        ends = ranges * np.exp(1j * ANGLES) + LASER.x
        watch.update(0.2 * number, Pose(0.0, 0.0, heading), np.column_stack((ends.real, ends.imag)))
        if watch.fault is not None:
            return 4.0 * number
    return None


@pytest.mark.parametrize("degrees", [0.0, 1.0, -2.0])
def test_a_laser_as_configured_within_the_tolerance_is_no_fault(degrees: float) -> None:
    mount = LASER._replace(theta=math.radians(degrees))
    assert drive(TravelWatch(), mount=mount) is None
    assert drive(TravelWatch(), mount=mount, bend=-0.4) is None


@pytest.mark.parametrize("degrees", [-170.0, -90.0, -45.0, -10.0, 10.0, 45.0, 86.0, 135.0, 180.0])
def test_a_turned_laser_is_found_with_its_angle(degrees: float) -> None:
    watch = TravelWatch()
    found = drive(watch, mount=LASER._replace(theta=math.radians(degrees)))
    assert found is not None
    assert found < (0.7 if abs(degrees) > 20.0 else 1.5)
    assert watch.fault is TravelFault.TURNED
    assert abs(math.remainder(watch.turned_deg - degrees, 360.0)) <= 10.0


def test_scans_confirm_the_mount_within_half_a_metre_or_what_they_cannot_show_is_let_be() -> None:
    watch = TravelWatch()
    drive(watch, metres=0.3)
    assert not watch.confirmed
    drive(watch, metres=0.6)
    assert watch.confirmed
    watch.restart()
    assert not watch.confirmed
    drive(watch, mount=LASER._replace(theta=0.2), metres=0.6)
    assert not watch.confirmed
    unseen = TravelWatch()
    drive(unseen, walls=ROOM * 100.0, metres=2.5)
    assert not unseen.confirmed
    drive(unseen, walls=ROOM * 100.0, metres=3.5)
    assert unseen.confirmed


def test_a_mirrored_laser_is_found_by_a_turn_in_place() -> None:
    watch = TravelWatch()
    found = spin(watch, mirrored=True)
    assert found is not None
    assert found <= 60.0
    assert watch.fault is TravelFault.MIRRORED
    assert spin(TravelWatch(), mirrored=False) is None


def test_a_laser_that_repeats_its_scan_with_noise_is_found() -> None:
    watch = TravelWatch()
    found = drive(watch, repeats=True)
    assert found is not None
    assert found < 0.8
    assert watch.fault is TravelFault.REPEATS


def test_slip_and_one_wrong_scan_are_no_fault() -> None:
    assert drive(TravelWatch(), slip=0.3) is None
    assert drive(TravelWatch(), turned_at=17) is None


@pytest.mark.parametrize("scaled", [0.88, 1.0, 1.03, 1.1])
def test_ranges_of_another_scale_than_the_wheels_are_told(scaled: float) -> None:
    watch = TravelWatch()
    assert drive(watch, scaled=scaled, bend=1.2, metres=12.0) is None
    if abs(scaled - 1.0) < TOLERANCE:
        assert watch.scale.off is None
    else:
        assert watch.scale.off == pytest.approx(scaled - 1.0, abs=0.02)


def test_slip_now_and_then_is_no_scale() -> None:
    scale = TravelScale()
    sure = np.eye(2) * 1e6
    for number in range(30):
        slipped = 0.3 if number % 4 == 0 else 0.0
        scale.add(Pose(0.6, 0.0, 0.0), Pose(0.6 * (1.0 - slipped), 0.0, 0.0), sure)
    assert scale.off is None


def test_a_way_that_scans_do_not_show_is_no_sample() -> None:
    scale = TravelScale()
    for _ in range(30):
        scale.add(Pose(0.6, 0.0, 0.0), Pose(0.0, 0.0, 0.0), np.diag((1.0, 1e6)))
    assert scale.off is None


def test_what_a_corridor_does_not_show_is_not_judged() -> None:
    backwards = LASER._replace(theta=math.pi)
    assert drive(TravelWatch(), walls=CORRIDOR, bend=0.0) is None
    assert drive(TravelWatch(), walls=CORRIDOR, bend=0.0, mount=backwards) is None
    assert drive(TravelWatch(), walls=CORRIDOR, bend=0.0, repeats=True) is None


def test_the_floor_ahead_of_a_tilted_scanner_is_no_repeated_scan() -> None:
    watch = TravelWatch()
    assert drive(watch, walls=DOORS, bend=0.0, floor=5.7, metres=15.0) is None
    assert watch.confirmed


def test_where_nothing_returns_nothing_is_judged() -> None:
    assert drive(TravelWatch(), walls=ROOM * 100.0, repeats=True) is None


def test_a_fault_lasts_until_the_watch_is_restarted() -> None:
    watch = TravelWatch()
    drive(watch, repeats=True)
    drive(watch)
    assert watch.fault is TravelFault.REPEATS
    watch.restart()
    assert watch.fault is None
    assert drive(watch) is None
