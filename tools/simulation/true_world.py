"""A simulated world as a truth says: the building with what no map shows, and its sensors."""

from __future__ import annotations

import numpy as np

from maps.map_folder import MapFolder
from tools.simulation.laser_optics import LaserOptics
from tools.simulation.sonar_echo import SonarEcho
from tools.simulation.surroundings import surroundings_of
from tools.simulation.truth.truth import Truth
from tools.simulation.uneven_floor import UnevenFloor
from tools.simulation.world import World


def make_world(folder: MapFolder, rng: np.random.Generator, truth: Truth) -> World:
    """Return the world of a map that a truth describes, without robots.

    What the truth leaves to the seed is drawn from a generator of its own.
    """
    draws = rng.spawn(1)[0]
    truth = truth.drawn(draws)
    around = surroundings_of(folder.map, folder.border, truth.things, draws)
    optics = LaserOptics(folder.map, truth.optics, draws) if truth.optics.surfaces else None
    floor = None
    if folder.border is not None and truth.floor.sills + truth.floor.slopes > 0:
        floor = UnevenFloor(folder.map, folder.border, truth.floor, draws)
    return World(
        around.touched,
        rng,
        truth.noise,
        surroundings=around,
        optics=optics,
        echo=SonarEcho(truth.sonar, rng),
        floor=floor,
    )
