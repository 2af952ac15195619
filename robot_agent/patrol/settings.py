"""Settings of the patrol: gains, speeds, distances, reversal, rules, modifiers."""

from __future__ import annotations

from typing import Annotated, Literal, get_args

import msgspec

from robot_agent.patrol.reversal import Distribution

Positive = Annotated[float, msgspec.Meta(gt=0.0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0.0)]
Share = Annotated[float, msgspec.Meta(ge=0.0, le=1.0)]

STANDOFF = "standoff"
HOLD_AT_END = "hold_at_end"
BLOCKAGE = "blockage"
CLOSING_IN = "closing_in"
COMMON_TURNS = "common_turns"
EVEN_GAPS = "even_gaps"
AROUND_WALLS = "around_walls"
DWELL = "dwell"
ModifierName = Literal[
    "standoff",
    "hold_at_end",
    "blockage",
    "closing_in",
    "common_turns",
    "even_gaps",
    "around_walls",
    "dwell",
]
DEFAULT_MODIFIERS: tuple[ModifierName, ...] = get_args(ModifierName)
PAPER_STRATEGY: tuple[ModifierName, ...] = tuple(
    name for name in DEFAULT_MODIFIERS if name not in (COMMON_TURNS, EVEN_GAPS)
)
"""Robots that turn where the paper's do, kept from deadlocks: ``patrol paper``, and the default of
recordings that have ``patrol.strategy``."""


class PatrolSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of one robot's patrol; the printed values of the paper are marked [paper]."""

    reach_gain: Annotated[
        Positive,
        msgspec.Meta(description="of Reach Frontier, lambda_rf [paper]", extra={"unit": "1/s"}),
    ] = 0.3
    avoid_gain: Annotated[
        Positive,
        msgspec.Meta(description="of avoidance, lambda_ta [paper]", extra={"unit": "1/s"}),
    ] = 0.3
    approach_speed: Annotated[
        Positive,
        msgspec.Meta(
            description="limit of Reach Frontier and of every sum [paper]", extra={"unit": "m/s"}
        ),
    ] = 0.5
    patrol_speed: Annotated[
        Positive,
        msgspec.Meta(description="lambda_cw = lambda_ccw [paper]", extra={"unit": "m/s"}),
    ] = 0.35
    escape_speed: Annotated[
        Positive,
        msgspec.Meta(description="limit of Teammate Avoidance [paper]", extra={"unit": "m/s"}),
    ] = 0.3
    safety_distance: Annotated[
        Positive,
        msgspec.Meta(description="a nearer teammate is avoided, d_s", extra={"unit": "m"}),
    ] = 2.4
    patrolling_distance: Annotated[
        Positive,
        msgspec.Meta(
            description="theta_th1: nearer the border a teammate patrols [paper]",
            extra={"unit": "m"},
        ),
    ] = 0.7
    passing_distance: Annotated[
        Positive,
        msgspec.Meta(
            description="theta_th2: farther from it a teammate does not [paper]",
            extra={"unit": "m"},
        ),
    ] = 2.0
    reversal_period: Annotated[
        Positive,
        msgspec.Meta(
            description="between random decisions to turn back [paper]", extra={"unit": "s"}
        ),
    ] = 27.0
    reversal_distribution: Annotated[
        Distribution,
        msgspec.Meta(description="of the times between: fixed, uniform or exponential"),
    ] = "fixed"
    reversal_probability: Annotated[
        Share,
        msgspec.Meta(description="of turning back then; the paper gives none"),
    ] = 0.1
    common_secret: Annotated[
        str,
        msgspec.Meta(
            description="of common_turns, the same on all robots and known to nobody else; "
            "unset: no common turns"
        ),
    ] = ""
    team_size: Annotated[
        int,
        msgspec.Meta(
            ge=0,
            description="robots on the border, for even_gaps, until one cannot get round; 0: "
            "counted by their meetings",
        ),
    ] = 0
    clock_drift: Annotated[
        float,
        msgspec.Meta(
            description="that this robot's clock gains, for common_turns", extra={"unit": "s/day"}
        ),
    ] = 0.0
    longest_idleness: Annotated[
        NotNegative,
        msgspec.Meta(
            description="that common turns may lead to; 0: a little over twice the even gap",
            extra={"unit": "s"},
        ),
    ] = 0.0
    turning_radius: Annotated[
        Positive,
        msgspec.Meta(
            description="tighter borders are refused; at 0.35 m/s this one is missed by 0.045 m",
            extra={"unit": "m"},
        ),
    ] = 0.5
    supervisor: Annotated[
        Literal["fuzzy", "automaton"],
        msgspec.Meta(description="fuzzy rules [paper], or a finite state automaton in their place"),
    ] = "fuzzy"
    reading: Annotated[
        Literal["R1", "R2", "R3"], msgspec.Meta(description="of the damaged cell of Table I")
    ] = "R1"
    rules_file: Annotated[
        str, msgspec.Meta(description="another rule file in place of the shipped rules.toml")
    ] = ""
    modifiers: Annotated[
        tuple[ModifierName, ...],
        msgspec.Meta(
            description="what is on beyond the paper, in order of precedence; [] is the paper"
        ),
    ] = DEFAULT_MODIFIERS

    def __post_init__(self) -> None:
        """Raise ValueError for thresholds or speeds out of order and modifiers named twice."""
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
        if COMMON_TURNS in self.modifiers and (
            EVEN_GAPS not in self.modifiers
            or self.modifiers.index(EVEN_GAPS) < self.modifiers.index(COMMON_TURNS)
        ):
            raise ValueError("modifiers: common_turns needs even_gaps after it; leave out both")
        if len(set(self.modifiers)) < len(self.modifiers):
            raise ValueError("modifiers names one twice")
