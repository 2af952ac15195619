"""Settings of the localizer, with the defaults and the ranges they are checked against."""

from __future__ import annotations

from typing import Annotated

import msgspec

Positive = Annotated[float, msgspec.Meta(gt=0.0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0.0)]
Share = Annotated[float, msgspec.Meta(ge=0.0, le=1.0)]
Count = Annotated[int, msgspec.Meta(ge=1)]


class MotionSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Standard deviations of the odometry's errors, proportional to what it counted.

    The floors are added at every update and may not be zero: a filter without them freezes while
    the wheels slip or the robot is turned by hand.
    """

    rotation_per_rotation: NotNegative = 0.1  # rad/rad
    rotation_per_translation: NotNegative = 0.07  # rad/m
    translation_per_translation: NotNegative = 0.07  # m/m
    translation_per_rotation: NotNegative = 0.03  # m/rad
    floor_xy: Positive = 0.01  # m
    floor_theta: Positive = 0.01  # rad
    slip_share: Share = 0.05  # of the particles, moved as if the wheels had slipped
    slip_xy: NotNegative = 0.1  # m
    slip_theta: NotNegative = 0.1  # rad


class SensorSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Likelihood of a beam's end point by its distance from the nearest mapped obstacle."""

    beams: Count = 60  # at most, spread evenly over the scan
    independent_beams: Positive = 12.0  # what the beams of one scan are worth together
    full_step_xy: Positive = 0.2  # m of travel after which a scan counts in full
    full_step_theta: Positive = 0.2  # rad of turning likewise
    still_worth: Share = 0.3  # of a scan where the last one was taken: it errs like that one
    sigma: Positive = 0.1  # m; of laser, map and particle spacing together
    random_share: Annotated[float, msgspec.Meta(gt=0.0, lt=1.0)] = 0.1  # people, teammates


class SampleSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Number of particles: fixed, or by KLD sampling between a minimum and a maximum."""

    fixed: Count | None = None  # None: KLD sampling
    minimum: Count = 200
    maximum: Count = 5000
    bin_xy: Positive = 0.1  # m
    bin_theta: Positive = 0.087  # rad
    error: Positive = 0.05  # bound on the KL divergence
    quantile: Positive = 2.33  # of the standard normal: 99 %
    resample_below: Share = 0.5  # effective share of the particles

    def __post_init__(self) -> None:
        if self.minimum > self.maximum:
            raise ValueError("minimum must not exceed maximum")


class RefinementSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Scan-to-map refinement of the estimate."""

    points: Count = 180  # at most, spread evenly over the scan
    steps: Count = 4
    independent_points: Positive = 60.0  # what the points of one scan are worth together
    sigma: Positive = 0.05  # m; of an end point's distance from the mapped surface
    kernel: Positive = 0.15  # m; end points farther from the map than this hardly pull
    least_xy: Positive = 0.05  # m; a cloud of a few hundred samples is never surer than this
    least_theta: Positive = 0.025  # rad; likewise
    limit_xy: Positive = 0.3  # m
    limit_theta: Positive = 0.15  # rad


class HealthSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Thresholds between localized, unsure and lost.

    The thresholds to get better are stricter than those to get worse, and a change must be
    confirmed by several updates in a row.
    """

    sigma: Positive = 0.1  # m; an end point this far from the map fits by 61 %
    unsure_below: Share = 0.55  # mean fit of the scan
    localized_above: Share = 0.65
    lost_below: Share = 0.35
    found_above: Share = 0.45
    unsure_spread: Positive = 0.4  # m
    localized_spread: Positive = 0.3  # m
    unsure_share: Share = 0.7  # of the weight in the best cluster
    localized_share: Share = 0.85
    updates_to_worsen: Count = 3
    updates_to_improve: Count = 5

    def __post_init__(self) -> None:
        if not self.lost_below < self.found_above <= self.unsure_below < self.localized_above:
            raise ValueError(
                "thresholds must satisfy lost_below < found_above <= unsure_below < localized_above"
            )
        if not self.localized_spread < self.unsure_spread:
            raise ValueError("localized_spread must be below unsure_spread")
        if not self.unsure_share < self.localized_share:
            raise ValueError("unsure_share must be below localized_share")


class GlobalSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Search over the whole map, at an unknown start or once lost."""

    particles_per_area: Positive = 60.0  # 1/m^2 of free floor
    maximum: Count = 60000  # particles at the start
    maximum_after: Count = 20000  # particles until the robot is found
    kept: Count = 1000  # particles of the old belief, when a lost robot is searched for
    independent_beams: Positive = 3.0  # few, so that no place is given up on one scan
    clearance: NotNegative = 0.2  # m between a particle and a wall
    after_lost: Annotated[int, msgspec.Meta(ge=0)] = 20  # updates lost; 0: never by itself
    after_unsure: Annotated[int, msgspec.Meta(ge=0)] = 100  # updates unsure; 0: never by itself


class LocalizationSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """All settings of the localizer."""

    motion: MotionSettings = MotionSettings()
    sensor: SensorSettings = SensorSettings()
    samples: SampleSettings = SampleSettings()
    refinement: RefinementSettings = RefinementSettings()
    health: HealthSettings = HealthSettings()
    search: GlobalSettings = GlobalSettings()
