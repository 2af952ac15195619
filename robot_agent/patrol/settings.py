"""What can be set about patrolling: gains, speeds, distances, the reversal, the rules."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

Positive = Annotated[float, msgspec.Meta(gt=0.0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0.0)]
Share = Annotated[float, msgspec.Meta(ge=0.0, le=1.0)]


class PatrolSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of one robot's patrol; the printed values of the paper are marked [paper]."""

    reach_gain: Positive = 0.3  # 1/s, lambda_rf [paper]
    avoid_gain: Positive = 0.3  # 1/s, lambda_ta [paper]
    approach_speed: Positive = 0.5  # m/s, limit of Reach Frontier and of every sum [paper]
    patrol_speed: Positive = 0.35  # m/s, lambda_cw = lambda_ccw [paper]
    escape_speed: Positive = 0.3  # m/s, limit of Teammate Avoidance [paper]
    safety_distance: Positive = 2.4  # m, d_s
    patrolling_distance: Positive = (
        0.7  # m, theta_th1: nearer the border a teammate patrols [paper]
    )
    passing_distance: Positive = 2.0  # m, theta_th2: farther from it a teammate does not [paper]
    same_place: NotNegative = (
        0.05  # m of abscissa within which left and right keep their last value
    )
    detour_ratio: Positive = 1.6  # a teammate farther along the border than this many times the
    detour_allowance: NotNegative = 1.0  # straight distance plus this many m is on another stretch
    reversal_period: Positive = 27.0  # s between random decisions to turn back [paper]
    reversal_probability: Share = 0.25
    reversal_end_distance: NotNegative = 0.8  # m from an end of an open border without any
    minimum_dwell: NotNegative = 0.5  # s an action lasts, unless Avoid Teammate is called for
    reading: Literal["R1", "R2", "R3"] = "R1"  # of the damaged cell of Table I
    rules_file: str = ""  # another rule file in place of the shipped rules.toml

    def __post_init__(self) -> None:
        """Refuse thresholds out of order."""
        if self.patrolling_distance >= self.passing_distance:
            raise ValueError(
                f"patrolling_distance {self.patrolling_distance} m must be below "
                f"passing_distance {self.passing_distance} m"
            )
        if self.patrol_speed > self.approach_speed:
            raise ValueError(
                f"patrol_speed {self.patrol_speed} m/s must not exceed "
                f"approach_speed {self.approach_speed} m/s"
            )
