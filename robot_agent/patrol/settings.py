"""What can be set about patrolling: gains, speeds, distances, reversal, rules, automaton."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from robot_agent.patrol.reversal import Distribution

Positive = Annotated[float, msgspec.Meta(gt=0.0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0.0)]
Share = Annotated[float, msgspec.Meta(ge=0.0, le=1.0)]


class AutomatonSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Thresholds of the transitions; a state once taken holds half a hysteresis beyond them."""

    border_distance: Positive = 1.5  # m; farther from the border: reach it
    encounter_border_distance: Positive = 0.7  # m; so near the border teammates turn, not avoid
    avoid_distance: Positive = 1.1  # m; a teammate nearer is avoided
    encounter_distance: Positive = 1.9  # m; a patrolling teammate nearer makes the robot turn
    encounter_gamma: Share = 0.375  # magnitude of gamma from which a teammate patrols
    end_distance: NotNegative = 0.55  # m from an end of an open border: turn
    hysteresis: NotNegative = 0.1  # m
    gamma_hysteresis: NotNegative = 0.1

    def __post_init__(self) -> None:
        """Refuse thresholds whose bands overlap, where a state could not be told."""
        if self.avoid_distance + self.hysteresis >= self.encounter_distance:
            raise ValueError(
                f"avoid_distance {self.avoid_distance} m and hysteresis {self.hysteresis} m must "
                f"together be below encounter_distance {self.encounter_distance} m"
            )
        if self.encounter_border_distance + self.hysteresis >= self.border_distance:
            raise ValueError(
                f"encounter_border_distance {self.encounter_border_distance} m and hysteresis "
                f"{self.hysteresis} m must together be below border_distance "
                f"{self.border_distance} m"
            )


class EvenGapsSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How robots of the strategy "even_gaps" learn and keep their gaps."""

    learning_laps: Positive = 1.5  # laps of patrol by the rules alone, before the team is counted
    longest_learning_laps: Positive = 12.0  # when the way round proves blocked again and again
    slack: Annotated[float, msgspec.Meta(ge=1.0, le=2.0)] = 1.06  # of the gap to leave: a robot
    # met at that distance was where it should be
    tolerance: Share = 0.15  # of the gap ahead, within which it counts as even
    memory: Positive = 3600.0  # s after which the team is counted anew


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
    reversal_distribution: Distribution = "fixed"  # of the times between; uniform, exponential
    reversal_probability: Share = 0.1  # the paper gives none; see README.md
    reversal_owes_way: bool = False  # none again before the way it turned from was driven
    reversal_rest: NotNegative = 2.0  # laps without any once a teammate stands on the border
    closing_in: Share = 0.5  # probability of coming closer to where teammates sent it back thrice
    closing_in_speed: Positive = 0.2  # m/s
    closing_in_wait: NotNegative = 4.0  # s at most that it stands after such a turn
    reversal_end_distance: NotNegative = 0.8  # m from an end of an open border without any
    turning_radius: Positive = 0.5  # m; tighter borders are refused. At patrol_speed 0.35 m/s the
    # robot is 0.045 m off an arc of 0.5 m (0.094 m of 0.35 m), which leaves 0.05 m to the pose
    blockage_time: Positive = 10.0  # s an object may hold the robot before it turns back
    blockage_neighbor_distance: Positive = 1.0  # m; a teammate so near may be that object
    standoff_time: Positive = 12.0  # s beside the border, or caught at its end, until it insists
    longest_avoiding: Positive = 20.0  # s of Avoid Teammate likewise, wherever it leads
    insisting_time: Positive = 8.0  # s of Reach Frontier then
    supervisor: Literal["fuzzy", "automaton"] = "fuzzy"
    minimum_dwell: NotNegative = 0.5  # s an action lasts, unless Avoid Teammate is called for
    reading: Literal["R1", "R2", "R3"] = "R1"  # of the damaged cell of Table I
    rules_file: str = ""  # another rule file in place of the shipped rules.toml
    automaton: AutomatonSettings = AutomatonSettings()
    strategy: Literal["paper", "even_gaps"] = "paper"  # what decides on turning back
    even_gaps: EvenGapsSettings = EvenGapsSettings()

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
        if self.supervisor == "automaton":
            self._check_automaton()

    def _check_automaton(self) -> None:
        """Refuse a safety distance at which robots would stop for good, as the rule file does."""
        farthest = self.automaton.encounter_distance + self.automaton.hysteresis / 2.0
        if self.safety_distance < farthest:
            raise ValueError(
                f"safety_distance {self.safety_distance} m must be at least {farthest} m, up to "
                "which the automaton avoids a teammate"
            )
