"""People as lasers see them."""

from __future__ import annotations

import numpy as np

from maps.occupancy_map import OccupancyMap
from maps.pose import Pose
from tools.simulation.legs import Legs
from tools.simulation.stranger import PERSON
from tools.simulation.truth.truth import load_truth
from tools.simulation.world import World


def test_two_legs_swing_against_each_other() -> None:
    standing, walking = Legs(0.12).at(0.0), Legs(0.12).at(0.35)
    assert [part.middle.x for part in standing] == [0.0, 0.0]
    assert walking[0].middle.x == -walking[1].middle.x
    assert abs(walking[0].middle.x) > 0.2
    assert standing[0].reach < 0.07


def test_a_laser_sees_between_the_legs_and_sonar_hears_the_person() -> None:
    cells = np.zeros((80, 80), dtype=np.uint8)
    world = World(
        OccupancyMap(cells, 0.05, Pose(0.0, 0.0, 0.0)),
        np.random.default_rng(1),
        load_truth("ideal").noise,
    )
    robot = world.add_body(Pose(1.0, 2.0, 0.0))
    legs = Legs(0.12)
    person = world.add_body(Pose(2.5, 2.0, 0.0), PERSON, legs.at(0.0))

    def seen() -> np.ndarray:
        return world.scan(robot, robot.pose, 181, np.radians(0.5), (0.0, 0.0, 0.0))

    first = seen()
    assert np.isinf(first[90])
    assert np.diff(np.isfinite(first).astype(int)).clip(0).sum() == 2
    world.show(person, legs.at(0.35))
    assert np.nanmin(seen()) < np.nanmin(first) - 0.15
