"""Rays from a coarse grid, against exact distances to the walls."""

from __future__ import annotations

import numpy as np
import pytest

from localization.cell_table import cell_table
from localization.ray_table import MARGIN, MOST_PLACES, RayTable
from maps.pose import Pose

POSES = [Pose(3.0, 2.0, 0.4), Pose(1.02, 1.07, -2.9), Pose(6.9, 2.95, 3.1)]


@pytest.fixture
def rays(room) -> RayTable:
    return RayTable(cell_table(room.map))


def longer(points, by: float):
    return points * (1.0 + by / np.linalg.norm(points, axis=1, keepdims=True))


@pytest.mark.parametrize("pose", POSES)
def test_beams_to_the_walls_do_not_pass_through_them_and_longer_ones_do(
    room, rays: RayTable, pose: Pose
) -> None:
    points, particle = room.scan(pose), np.array([pose])
    assert rays.through(particle, points).mean() < 0.04  # past corners
    assert rays.through(particle, 0.5 * points).mean() < 0.04
    assert rays.through(particle, longer(points, MARGIN + 0.2)).mean() > 0.9


def test_each_particle_has_its_own_answer(room, rays: RayTable) -> None:
    """A person can only be in front of a wall: at a pose nearer to it the scan goes through."""
    truth = Pose(3.0, 2.0, 0.0)
    nearer = truth.compose(Pose(1.0, 0.0, 0.0))
    through = rays.through(np.array([truth, nearer, truth]), room.scan(truth))
    assert through.shape == (181, 3)
    assert (through[:, 0] == through[:, 2]).all()
    assert through[:, 0].mean() < 0.04
    assert through[80:100, 1].all()


def test_headings_beyond_a_turn_are_the_same(room, rays: RayTable) -> None:
    pose, points = Pose(3.0, 2.0, 0.4), longer(room.scan(Pose(3.0, 2.0, 0.4)), 0.5)
    turned = np.array([[pose.x, pose.y, pose.theta + 2.0 * np.pi]])
    assert (rays.through(np.array([pose]), points) == rays.through(turned, points)).all()


def test_outside_the_map_nothing_is_in_the_way(rays: RayTable) -> None:
    assert not rays.through(np.array([[90.0, -70.0, 1.0]]), np.array([[5.0, 0.0]])).any()


def test_wide_beliefs_are_left_to_the_ends_of_the_beams(room, rays: RayTable) -> None:
    pose = Pose(3.0, 2.0, 0.4)
    behind = longer(room.scan(pose), 0.5)
    wide = np.array([pose._replace(x=0.11 * k) for k in range(MOST_PLACES + 1)])
    assert rays.through(wide[27:28], behind).any()
    assert not rays.through(wide, behind).any()
