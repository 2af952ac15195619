"""Settings of the localizer, by the user or a robot's model file."""

from __future__ import annotations

from typing import Annotated

import msgspec

NotNegative = Annotated[float, msgspec.Meta(ge=0.0)]


class MotionNoise(msgspec.Struct, frozen=True, kw_only=True):
    """Standard deviations of the odometry's errors, proportional to what it counted.

    The defaults are those of a two-wheeled Pioneer.
    """

    rotation_per_rotation: float = 0.1  # rad/rad
    rotation_per_translation: float = 0.07  # rad/m
    translation_per_translation: float = 0.07  # m/m
    translation_per_rotation: float = 0.03  # m/rad


class MotionSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Standard deviations of the odometry's errors where they are set; None: the model's."""

    rotation_per_rotation: Annotated[
        NotNegative | None,
        msgspec.Meta(
            description="Odometry's error in heading per heading turned; unset: the model's",
            extra={"unit": "rad/rad"},
        ),
    ] = None
    rotation_per_translation: Annotated[
        NotNegative | None,
        msgspec.Meta(
            description="Odometry's error in heading per distance driven; unset: the model's",
            extra={"unit": "rad/m"},
        ),
    ] = None
    translation_per_translation: Annotated[
        NotNegative | None,
        msgspec.Meta(
            description="Odometry's error in distance per distance driven; unset: the model's",
            extra={"unit": "m/m"},
        ),
    ] = None
    translation_per_rotation: Annotated[
        NotNegative | None,
        msgspec.Meta(
            description="Odometry's error in distance per heading turned; unset: the model's",
            extra={"unit": "m/rad"},
        ),
    ] = None

    def over(self, noise: MotionNoise) -> MotionNoise:
        """Return noise with the values that are set here in place of its own."""
        own = {
            name: value for name, value in msgspec.structs.asdict(self).items() if value is not None
        }
        return msgspec.structs.replace(noise, **own)


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
