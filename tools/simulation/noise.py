"""Noise of motion and sensors in the simulated world."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class WorldNoise:
    """Noise of motion and sensors, standard deviations. Set all to 0 for a perfect world.

    Motion errors grow with the square root of the distance, independent of the step size:
    slip_distance 0.01 is 1 % of the first metre.
    """

    slip_distance: float = 0.01  # m after 1 m: motion of the body against its wheels
    slip_rotation: float = 0.02  # rad after 1 rad turned
    slip_heading: float = 0.01  # rad after 1 m driven
    wheel_scale: float = 0.0075  # share; systematic odometer error of each wheel, drawn once
    odometer: float = 0.005  # m after 1 m; random odometer error of each wheel
    laser_range: float = 0.01  # m
    laser_dropouts: float = 0.001  # share of beams without a return
    sonar_range: float = 0.02  # m


NO_NOISE = WorldNoise(
    slip_distance=0.0,
    slip_rotation=0.0,
    slip_heading=0.0,
    wheel_scale=0.0,
    odometer=0.0,
    laser_range=0.0,
    laser_dropouts=0.0,
    sonar_range=0.0,
)
