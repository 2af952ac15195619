"""Settings of teammate detection."""

from __future__ import annotations

from typing import Annotated

import msgspec

from robot_agent.perception.color_settings import ColorSettings

Positive = Annotated[float, msgspec.Meta(gt=0.0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0.0)]


class PerceptionSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How unexplained points become segments, tracks and teammates; m, rad, s, m/s.

    Raises ValueError (msgspec's ValidationError when decoding) if limits are not ordered.
    """

    # What the map explains: points nearer to an occupied cell than
    # explained_distance + range * explained_angle.
    explained_distance: Positive = 0.15  # m; map and position error
    explained_angle: NotNegative = 0.035  # rad; heading error, two sigma
    detection_range: Positive = 4.0  # m; beyond visibility, so that tracks exist on entering it

    # What a Pioneer looks like in the plane of the laser.
    segment_gap: Positive = 0.10  # m between neighbouring points of one object, close up
    min_extent: Positive = 0.30  # m across the line of sight, both edges in view
    min_partial_extent: Positive = 0.12  # m, an edge hidden by something nearer or out of view
    max_extent: Positive = 0.75  # m
    max_stranger_extent: Positive = 1.1  # m; larger things are furniture
    min_person_extent: Positive = 0.22  # m; smaller ones are legs, and count by twos
    stride: Positive = 0.55  # m between two legs of one person
    half_width: Positive = 0.27  # m from the centre to an edge, mean over headings

    # How well a pose is known; adds to each position's covariance.
    pose_sigma_xy: NotNegative = 0.05  # m
    pose_sigma_theta: NotNegative = 0.0175  # rad

    # Tracks.
    confirm_hits: Annotated[int, msgspec.Meta(ge=1)] = 3  # detections until a track counts
    velocity_noise: Positive = 0.05  # m^2/s^3; spectral density of the acceleration
    first_speed_sigma: Positive = 0.35  # m/s; of a new track's velocity, per axis
    gate: Positive = 11.8  # squared Mahalanobis distance: 99.7 % of two dimensions
    gate_distance: Positive = 1.0  # m; no association beyond, however uncertain the track
    memory: Positive = 3.0  # s a confirmed track is kept unseen
    cover: Positive = (
        0.45  # m from the centre of a track just seen: its beams tell nothing of walls
    )
    cover_memory: Positive = 0.5  # s that a track counts as just seen
    max_covered: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)] = 0.5  # of a scan's beams
    velocity_decay: Positive = 1.0  # s; time constant of an unseen track's velocity

    # What makes a robot-sized track a teammate where no camera tells: it moves.
    motion_window: Positive = 2.5  # s over which displacement is judged
    motion_distance: Positive = 0.20  # m, beyond twice the position's sigma

    max_robot_speed: Positive = 0.65  # m/s; whoever is faster is none of the team
    reflecting_bands: bool = False  # teammates wear reflecting tape at the laser's height

    # What sonars tell of a track that no laser sees.
    sonar_gate: Positive = 0.5  # m from the track to an echo of it
    sonar_sigma: Positive = 0.2  # m
    sonar_memory: Positive = 6.0  # s after the laser saw it last

    # What the patrol is told.
    visibility: Positive = 2.5  # m; the paper's visibility range (section III)
    visibility_margin: NotNegative = 0.1  # m; a teammate in view is kept this much farther

    # Who is reported as an intruder.
    intruder_distance: Positive = 2.0  # m from the border
    intruder_time: Positive = 3.0  # s there
    intruder_memory: Positive = 60.0  # s unseen within which whoever comes back is the same

    # What teammates wear, where there is a camera.
    color: ColorSettings = ColorSettings()

    def __post_init__(self) -> None:
        """Check the order of limits."""
        if not self.min_partial_extent <= self.min_extent < self.max_extent:
            raise ValueError("extents must satisfy min_partial_extent <= min_extent < max_extent")
        if not self.min_person_extent <= self.min_extent:
            raise ValueError("min_person_extent must be at most min_extent")
        if self.max_stranger_extent < self.max_extent:
            raise ValueError("max_stranger_extent must be at least max_extent")
        if self.detection_range < self.visibility + self.visibility_margin:
            raise ValueError(
                "detection_range must be at least visibility + visibility_margin "
                f"({self.visibility + self.visibility_margin:g} m)"
            )
