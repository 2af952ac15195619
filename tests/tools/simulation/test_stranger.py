"""Strangers move near the border without contacts."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from maps.map_folder import load_map_folder
from robot_agent.config import find_map
from tools.simulation.robot_body import BodyKind
from tools.simulation.start_poses import free_start_poses
from tools.simulation.stranger import StrangerError, make_strangers
from tools.simulation.world import World


def test_strangers_move_near_the_border_without_contacts() -> None:
    folder = load_map_folder(find_map("paper_lab", Path.cwd()))
    assert folder.border is not None
    world = World(folder.map, np.random.default_rng(2))
    for pose in free_start_poses(folder.map, folder.border, 2, np.random.default_rng(3)):
        world.add_body(pose)
    strangers = make_strangers(world, folder.border, 2, seed=4)
    assert [each.body.kind for each in strangers] == [BodyKind.PERSON, BodyKind.BOX]
    walked, near = [0.0, 0.0], 0
    for _ in range(2000):
        before = [each.body.pose for each in strangers]
        for each in strangers:
            each.advance(0.05)
        for body in world.bodies[:2]:
            world.move(body, 0.0, 0.0)
        for number, each in enumerate(strangers):
            pose = each.body.pose
            walked[number] += math.dist(pose[:2], before[number][:2])
            near += folder.border.project(pose.x, pose.y).distance < 2.0
    assert min(walked) > 8.0
    assert near > 2000, "of 4000 moments"
    assert world.contacts == 0


def test_same_seed_gives_same_motion_and_full_world_is_refused() -> None:
    folder = load_map_folder(find_map("paper_lab", Path.cwd()))
    assert folder.border is not None
    places = []
    for _ in range(2):
        world = World(folder.map, np.random.default_rng(2))
        [stranger] = make_strangers(world, folder.border, 1, seed=4)
        for _ in range(400):
            stranger.advance(0.05)
        places.append(stranger.body.pose)
    assert places[0] == places[1]
    with pytest.raises(StrangerError, match="fewer --strangers"):
        make_strangers(world, folder.border, 200, seed=4)
