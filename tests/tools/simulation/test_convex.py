"""Bodies touch as the polygons they are."""

from __future__ import annotations

import math

import numpy as np
import pytest

from maps.occupancy_map import OccupancyMap
from maps.pose import Pose
from tools.simulation.convex import convex_overlap, grown
from tools.simulation.rig import make_rig
from tools.simulation.truth.truth import load_truth
from tools.simulation.world import World

SQUARE = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))


def test_a_square_grows_by_the_margin_on_every_side() -> None:
    assert grown(SQUARE, 0.1) == pytest.approx(
        np.array([(-0.1, -0.1), (1.1, -0.1), (1.1, 1.1), (-0.1, 1.1)])
    )


@pytest.mark.parametrize(("shift", "overlaps"), [((0.9, 0.9), True), ((1.1, 0.0), False)])
def test_squares_overlap_until_a_side_separates_them(
    shift: tuple[float, float], overlaps: bool
) -> None:
    square = np.array(SQUARE)
    assert convex_overlap(square, square + shift) == overlaps
    assert convex_overlap(square + shift, square) == overlaps


def world_of(name: str) -> World:
    cells = np.zeros((100, 100), dtype=np.uint8)
    world = World(
        OccupancyMap(cells, 0.05, Pose(0.0, 0.0, 0.0)),
        np.random.default_rng(1),
        load_truth("ideal").noise,
    )
    # Their rectangles overlap by a corner, which an octagon does not have.
    robot = load_truth(name).robot
    for pose in (Pose(2.0, 2.0, 0.0), Pose(2.47, 2.37, 0.0)):
        make_rig(f"robot{len(world.bodies)}", world, pose, 0.0, robot)
    return world


def test_octagons_pass_where_rectangles_touch() -> None:
    world = world_of("octagon")
    for body in world.bodies:
        assert not world.move(body, 0.0, 0.0).touching
    with pytest.raises(ValueError, match="stands in a wall or in another robot"):
        world_of("rectangle")


def test_an_octagon_is_stopped_by_its_own_sides() -> None:
    world = world_of("octagon")
    motions = [world.move(world.bodies[0], 0.01, 0.0) for _ in range(60)]
    assert world.contacts == 1
    assert motions[-1].touching
    assert motions[-1].front_bumpers
    assert 2.0 < world.bodies[0].pose.x < 2.3
    assert math.isclose(world.bodies[0].pose.y, 2.0)
