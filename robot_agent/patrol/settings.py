"""What can be set about patrolling: gains, speeds, distances, reversal, rules, modifiers."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from robot_agent.patrol.reversal import Distribution

Positive = Annotated[float, msgspec.Meta(gt=0.0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0.0)]
Share = Annotated[float, msgspec.Meta(ge=0.0, le=1.0)]

STANDOFF = "standoff"
HOLD_AT_END = "hold_at_end"
BLOCKAGE = "blockage"
CLOSING_IN = "closing_in"
EVEN_GAPS = "even_gaps"
AROUND_WALLS = "around_walls"
DWELL = "dwell"
ModifierName = Literal[
    "standoff", "hold_at_end", "blockage", "closing_in", "even_gaps", "around_walls", "dwell"
]
DEFAULT_MODIFIERS: tuple[ModifierName, ...] = (
    "standoff",
    "hold_at_end",
    "blockage",
    "closing_in",
    "around_walls",
    "dwell",
)


class PatrolSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of one robot's patrol; the printed values of the paper are marked [paper]."""

    reach_gain: Positive = 0.3
    """1/s, lambda_rf [paper]"""
    avoid_gain: Positive = 0.3
    """1/s, lambda_ta [paper]"""
    approach_speed: Positive = 0.5
    """m/s, limit of Reach Frontier and of every sum [paper]"""
    patrol_speed: Positive = 0.35
    """m/s, lambda_cw = lambda_ccw [paper]"""
    escape_speed: Positive = 0.3
    """m/s, limit of Teammate Avoidance [paper]"""
    safety_distance: Positive = 2.4
    """m, d_s"""
    patrolling_distance: Positive = 0.7
    """m, theta_th1: nearer the border a teammate patrols [paper]"""
    passing_distance: Positive = 2.0
    """m, theta_th2: farther from it a teammate does not [paper]"""
    reversal_period: Positive = 27.0
    """s between random decisions to turn back [paper]"""
    reversal_distribution: Distribution = "fixed"
    """of the times between: fixed, uniform or exponential"""
    reversal_probability: Share = 0.1
    """of turning back then; the paper gives none"""
    turning_radius: Positive = 0.5
    """m; tighter borders are refused: at 0.35 m/s the robot is 0.045 m off an arc of 0.5 m"""
    supervisor: Literal["fuzzy", "automaton"] = "fuzzy"
    """fuzzy rules [paper], or a finite state automaton in their place"""
    reading: Literal["R1", "R2", "R3"] = "R1"
    """of the damaged cell of Table I"""
    rules_file: str = ""
    """another rule file in place of the shipped rules.toml"""
    modifiers: tuple[ModifierName, ...] = DEFAULT_MODIFIERS
    """what is on beyond the paper, the first has the last word; [] is the paper alone"""
    minimum_dwell: NotNegative = 0.5
    """s an action lasts, unless Avoid Teammate is called for (modifier dwell)"""
    standoff_time: Positive = 12.0
    """s beside the border, or caught at its end, until it insists (modifier standoff)"""
    blockage_time: Positive = 10.0
    """s an object may hold the robot before it turns back (modifier blockage)"""

    def __post_init__(self) -> None:
        """Refuse thresholds out of order and modifiers named twice."""
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
        if len(set(self.modifiers)) < len(self.modifiers):
            raise ValueError("modifiers names one twice")
