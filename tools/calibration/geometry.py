"""Where the laser sits on a robot, and what its wheels are."""

from __future__ import annotations

from dataclasses import dataclass

from maps.pose import Pose


@dataclass(frozen=True, slots=True)
class Geometry:
    """What is fitted: mount, base_from_laser; scales of the wheels' counts; track, m; whether the
    laser's image is mirrored, as by one upside down."""

    mount: Pose
    left: float
    right: float
    track: float
    upside_down: bool
