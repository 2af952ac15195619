"""Surfaces, edges and noise as lasers meet them."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest

from maps.occupancy_map import OccupancyMap
from maps.pose import Pose
from tools.simulation.fan import laser_fan
from tools.simulation.laser_optics import LaserOptics
from tools.simulation.truth.robot_truth import TapeTruth
from tools.simulation.truth.surroundings_truth import OpticsTruth, SurfaceTruth
from tools.simulation.truth.truth import load_truth
from tools.simulation.world import World

PLASTER = SurfaceTruth(share=1.0, offset=0.0, noise=0.0, reach=80.0, facing=math.pi / 2, glare=0.0)
SILENT = msgspec.structs.replace(load_truth("ideal").noise, laser_range=0.0)


def make_world(surface: SurfaceTruth, mixed: float = 0.0) -> World:
    """A hall of 10 by 4 m, in which a pillar stands at (5, 3), as one surface."""
    cells = np.zeros((80, 200), dtype=np.uint8)
    cells[[0, -1]] = 1
    cells[:, [0, -1]] = 1
    cells[55:65, 95:105] = 1
    occupancy = OccupancyMap(cells, 0.05, Pose(0.0, 0.0, 0.0))
    rng = np.random.default_rng(1)
    optics = LaserOptics(occupancy, OpticsTruth(surfaces={"only": surface}, mixed=mixed), rng)
    return World(occupancy, rng, SILENT, optics=optics)


def scan_of(world: World) -> np.ndarray:
    body = world.bodies[0] if world.bodies else world.add_body(Pose(2.0, 1.0, 0.3))
    return world.scan(body, body.pose, 361, math.radians(0.5), (0.0, 0.0, 0.0))


def test_a_plain_surface_is_measured_as_it_is() -> None:
    world = make_world(PLASTER)
    true = World(world.occupancy, np.random.default_rng(1), SILENT)
    assert scan_of(world) == pytest.approx(scan_of(true), abs=1e-9)


def test_a_surface_shifts_ranges_by_its_offset() -> None:
    plain, shifted = (
        scan_of(make_world(msgspec.structs.replace(PLASTER, offset=offset)))
        for offset in (0.0, 0.01)
    )
    assert shifted - plain == pytest.approx(0.01)


def test_noise_grows_with_the_range() -> None:
    world = make_world(msgspec.structs.replace(PLASTER, noise=0.005))
    scans = np.array([scan_of(world) for _ in range(100)])
    far, deviation = scans.mean(axis=0), scans.std(axis=0)
    assert deviation[far > 6.0].mean() > 1.2 * deviation[far < 2.0].mean()


def test_nothing_returns_from_a_dark_surface_far_away() -> None:
    plain, dark = (
        scan_of(make_world(PLASTER)),
        scan_of(make_world(msgspec.structs.replace(PLASTER, reach=5.0))),
    )
    assert np.isinf(dark[plain > 5.0]).all()
    assert np.isfinite(dark[plain < 5.0]).all()


def test_a_shiny_surface_returns_near_its_normal_alone() -> None:
    world = make_world(msgspec.structs.replace(PLASTER, facing=0.5))
    ranges = scan_of(world)
    directions = 0.3 + np.radians(np.linspace(-90.0, 90.0, 361))
    seen = np.isfinite(ranges)
    off_axis = np.abs(np.remainder(directions + math.pi / 4, math.pi / 2) - math.pi / 4)
    assert seen.any()
    assert (off_axis[seen] < 0.5).all()


def test_a_beam_at_an_edge_returns_something_between() -> None:
    sharp, mixed = scan_of(make_world(PLASTER)), scan_of(make_world(PLASTER, mixed=1.0))
    changed = np.flatnonzero(np.abs(sharp - mixed) > 1e-6)
    assert 1 <= len(changed) <= 4  # the two edges of the pillar
    for beam in changed:
        near, far = sorted((sharp[beam - 1 : beam + 2].min(), sharp[beam]))
        assert near < mixed[beam] < far


def test_bodies_have_no_surface_of_a_wall() -> None:
    world = make_world(msgspec.structs.replace(PLASTER, reach=0.1))
    world.add_body(Pose(2.0, 1.0, 0.3))
    world.add_body(Pose(3.5, 1.5, 0.0))
    assert np.isfinite(scan_of(world)).sum() > 10


def test_a_shiny_surface_passes_for_a_reflector_at_its_normal_alone_where_tape_is_worn() -> None:
    world = make_world(msgspec.structs.replace(PLASTER, glare=0.03))
    body = world.add_body(Pose(2.0, 1.0, 0.3))
    bearings = np.radians(np.linspace(-90.0, 90.0, 361))
    fan = laser_fan(body, body.pose, bearings, (0.0, 0.0, 0.0))
    assert world.scans([fan])[0].reflectors is None
    body.tape = TapeTruth(worn=True, facing=0.8, missed=0.0)
    reflectors = world.scans([fan])[0].reflectors
    assert reflectors is not None
    off_axis = np.abs(np.remainder(fan.angles + math.pi / 4, math.pi / 2) - math.pi / 4)
    assert 3 <= reflectors.sum() <= 15
    assert (off_axis[reflectors] < 0.03).all()
