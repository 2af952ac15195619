"""Settings of the localizer, by the user or a robot's model file."""

from __future__ import annotations

from typing import Annotated

import msgspec


class MotionSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Standard deviations of the odometry's errors, proportional to what it counted."""

    rotation_per_rotation: Annotated[
        float,
        msgspec.Meta(
            ge=0.0,
            description="Odometry's error in heading per heading turned; default: the model's",
            extra={"unit": "rad/rad"},
        ),
    ] = 0.1
    rotation_per_translation: Annotated[
        float,
        msgspec.Meta(
            ge=0.0,
            description="Odometry's error in heading per distance driven; default: the model's",
            extra={"unit": "rad/m"},
        ),
    ] = 0.07
    translation_per_translation: Annotated[
        float,
        msgspec.Meta(
            ge=0.0,
            description="Odometry's error in distance per distance driven; default: the model's",
            extra={"unit": "m/m"},
        ),
    ] = 0.07
    translation_per_rotation: Annotated[
        float,
        msgspec.Meta(
            ge=0.0,
            description="Odometry's error in distance per heading turned; default: the model's",
            extra={"unit": "m/rad"},
        ),
    ] = 0.03


class LocalizationSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Size of the particle filter and noise of the odometry.

    Raises ValueError (msgspec's ValidationError when decoding) if min_particles exceeds
    max_particles.
    """

    beams: Annotated[
        int,
        msgspec.Meta(
            ge=1,
            description="Beams of a scan that particles are weighed by, spread evenly, at most",
        ),
    ] = 60
    particles: Annotated[
        Annotated[int, msgspec.Meta(ge=1)] | None,
        msgspec.Meta(
            description="Fixed number of particles while tracking; unset: adapted to the spread"
        ),
    ] = None
    min_particles: Annotated[
        int, msgspec.Meta(ge=1, description="Fewest particles of the adapted number")
    ] = 500
    max_particles: Annotated[
        int,
        msgspec.Meta(
            ge=1, description="Most particles of the adapted number, while tracking and at a start"
        ),
    ] = 5000
    motion: MotionSettings = MotionSettings()

    def __post_init__(self) -> None:
        """Raise ValueError if min_particles exceeds max_particles."""
        if self.min_particles > self.max_particles:
            raise ValueError("min_particles must not exceed max_particles")
