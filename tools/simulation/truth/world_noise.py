"""Noise of motion and sensors in the simulated world."""

from __future__ import annotations

from typing import Annotated

import msgspec

Spread = Annotated[float, msgspec.Meta(ge=0.0)]
Share = Annotated[float, msgspec.Meta(ge=0.0, le=1.0)]


class WorldNoise(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Noise of motion and sensors, standard deviations; the shipped values say their source.

    Motion errors grow with the square root of the distance, independent of the step size:
    slip_distance 0.01 is 1 % of the first metre.
    """

    slip_distance: Spread  # m after 1 m: motion of the body against its wheels
    slip_rotation: Spread  # rad after 1 rad turned
    slip_heading: Spread  # rad after 1 m driven
    wheel_scale: Spread  # share; systematic odometer error of each wheel, drawn once
    odometer: Spread  # m after 1 m; random odometer error of each wheel
    laser_range: Spread  # m
    laser_dropouts: Share  # share of beams without a return
    sonar_range: Spread  # m
