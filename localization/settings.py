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
    slip_share: Share = 0.1  # of the particles, moved as if the wheels had slipped
    max_slip: Share = 0.5  # of the translation counted, lost by them at most
    slip_lasting: Share = 0.7  # of the particles that slipped, slip on at the next step
    slip_xy: NotNegative = 0.1  # m
    slip_theta: NotNegative = 0.1  # rad


class SensorSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Likelihood of a beam's end point by its distance from the nearest mapped obstacle."""

    beams: Count = 60  # at most, spread evenly over the scan
    independent_beams: Positive = 12.0  # what the beams of one scan count as together
    full_step_xy: Positive = 0.2  # m of travel after which a scan counts in full
    full_step_theta: Positive = 0.2  # rad of turning likewise
    still_worth: Share = 0.3  # of a scan where the last one was taken: it errs like that one
    sigma: Positive = 0.1  # m; of laser, map and particle spacing together
    random_share: Annotated[float, msgspec.Meta(gt=0.0, lt=1.0)] = 0.1  # people, teammates


class SampleSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Number of particles: fixed, or by KLD sampling between a minimum and a maximum."""

    fixed: Count | None = None  # None: KLD sampling
    minimum: Count = 500
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
    independent_points: Positive = 60.0  # what the points of one scan count as together
    sigma: Positive = 0.05  # m; of an end point's distance from the mapped surface
    covariance_points: Positive = 6.0  # what they are information when the covariance is stated
    min_residual: Positive = 0.01  # m; the laser's own noise
    kernel: Positive = 0.15  # m; end points farther from the map than this hardly pull
    min_xy: Positive = 0.05  # m; a cloud of a few hundred samples is never surer than this
    min_theta: Positive = 0.025  # rad; likewise
    limit_xy: Positive = 0.3  # m
    limit_theta: Positive = 0.15  # rad


class CheckSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Check of a scan against the map at one pose."""

    points: Count = 180  # at most, spread evenly over the scan
    sigma: Positive = 0.1  # m; an end point this far from the map fits by 61 %
    short: Positive = 0.3  # m; an end on free floor, farther than this from the map: a person
    excused: Share = 0.3  # of the beams, at most: that many people are thought possible
    hiding_reach: Positive = 1.5  # m; what hides more than that is nearer
    beside_above: Share = 0.85  # fit of what is seen beside it, for the pose to be trusted
    rays: Count = 45  # beams followed through the map, at most
    reach: Positive = 10.0  # m; how far they are followed
    margin: Positive = 0.3  # m before the end of a beam that may touch a wall


class HealthSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Thresholds between localized, unsure and lost.

    The thresholds to get better are stricter than those to get worse, and a change must be
    confirmed by several scans in a row. Scans taken a step apart count in full, those from the
    same place in part (``SensorSettings.still_worth``).
    """

    unsure_below: Share = 0.6  # mean fit of the scan
    localized_above: Share = 0.7
    lost_below: Share = 0.45
    found_above: Share = 0.5
    unsure_through: Share = 0.4  # of the beams pass through mapped walls
    localized_through: Share = 0.25
    unsure_spread: Positive = 0.4  # m
    localized_spread: Positive = 0.3  # m
    unsure_share: Share = 0.7  # of the weight in the best cluster
    localized_share: Share = 0.85
    jump_xy: Positive = 0.5  # m between the estimate and where the odometry would put it
    jump_theta: Positive = 0.5  # rad; a scan with a larger jump is unsure
    worsen_after: Positive = 1.3  # scans in a row
    improve_after: Positive = 4.0  # scans in a row

    def __post_init__(self) -> None:
        if not self.lost_below < self.found_above <= self.unsure_below < self.localized_above:
            raise ValueError(
                "thresholds must satisfy lost_below < found_above <= unsure_below < localized_above"
            )
        for worse, better in (
            ("unsure_through", "localized_through"),
            ("unsure_spread", "localized_spread"),
            ("localized_share", "unsure_share"),
        ):
            if not getattr(self, better) < getattr(self, worse):
                raise ValueError(f"{better} must be below {worse}")


class FloorSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Standard deviations no estimate is better than: the errors of map and laser mount."""

    xy: NotNegative = 0.0144  # m; of a place within a cell of 0.05 m
    theta: NotNegative = 0.005  # rad


class WindowSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Search round the estimate when a scan does not fit where the odometry puts it."""

    below: Share = 0.8  # fit of a scan that starts it
    above: Share = 0.75  # fit of a pose information going to
    gain: Share = 0.1  # by which it must fit better
    samples: Count = 3000
    reach_xy: Positive = 1.0  # m
    reach_theta: Positive = 0.6  # rad


class SlipSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Search back along the odometry's last step, for wheels that slipped."""

    most: Share = 0.5  # of a counted translation, lost at most
    candidates: Count = 10  # spread evenly up to it
    beams: Count = 180  # at most, spread evenly over the scan: few of them tell
    independent_beams: Positive = 60.0  # what they count as together
    gain: NotNegative = 2.0  # of log-likelihood, at a place information going to
    min_xy: Positive = 0.1  # m; a smaller shift is the filter's own work


class GlobalSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Search over the whole map, at an unknown start or once lost."""

    particles_per_area: Positive = 300.0  # 1/m^2 of free floor
    maximum: Count = 200000  # particles at the start
    maximum_after: Count = 20000  # particles until the robot is found
    closer_xy: NotNegative = 0.1  # m round particles that fit, looked at again: half their spacing
    closer_theta: NotNegative = 0.09  # rad; likewise
    kept: Count = 1000  # particles of the old belief, when a lost robot is searched for
    independent_beams: Positive = 6.0  # few, so that no place is given up on one scan
    min_effective: Share = 0.05  # of the particles, left by one scan at least
    remembered: Count = 16  # scans of the way, for the second opinion before the search ends
    stop_xy: Positive = 0.4  # m between them
    stop_theta: Positive = 0.4  # rad; likewise
    hidden_log_likelihood: float = -1.0  # mean of the beams of a scan too ill-fitting to decide
    clearance: NotNegative = 0.2  # m between a particle and a wall
    repeat_lost: NotNegative = 15.0  # scans lost until the search starts again; 0: never
    repeat_unsure: NotNegative = 4.0  # scans unsure and ill-fitting until then; 0: never


class LocalizationSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """All settings of the localizer."""

    motion: MotionSettings = MotionSettings()
    sensor: SensorSettings = SensorSettings()
    samples: SampleSettings = SampleSettings()
    refinement: RefinementSettings = RefinementSettings()
    floor: FloorSettings = FloorSettings()
    check: CheckSettings = CheckSettings()
    slip: SlipSettings = SlipSettings()
    window: WindowSettings = WindowSettings()
    health: HealthSettings = HealthSettings()
    search: GlobalSettings = GlobalSettings()
