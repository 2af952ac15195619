"""Comparison of an agent's decisions under other settings, or on another computer.

Only decisions on the recorded inputs are compared; the consequences of other decisions are not
simulated.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from robot_agent.messages.effects import Effect, Publish
from robot_agent.messages.streams import DecisionPayload, decode
from robot_agent.motion.gate_words import GATE_WORDS

ANOTHER_COMMAND = 0.01
"""Smallest difference of commands that counts, m/s or rad/s."""
EPISODE_PAUSE_S = 1.0
"""Largest time between differences of one episode, s."""


@dataclass
class Episode:
    """A period in which decisions differed."""

    start: float
    """Agent time."""
    end: float
    recorded: str
    now: str


@dataclass
class WhatIf:
    """Collects the differences between decisions before and now."""

    decisions: int = 0
    """Decisions compared, and those made on one side only."""
    other_action: int = 0
    other_command: int = 0
    other_gate: int = 0
    one_sided: int = 0
    """Decisions made only in the recording or only now."""
    largest_v: float = 0.0
    """Largest difference of commanded speed, m/s."""
    largest_w: float = 0.0
    """Largest difference of commanded turn rate, rad/s."""
    episodes: list[Episode] = field(default_factory=list)

    @property
    def equal(self) -> bool:
        """Whether there were decisions, and all were equal, with commands within the bound."""
        others = self.other_action + self.other_gate + self.other_command + self.one_sided
        return self.decisions > 0 and others == 0

    def compare(self, t: float, recorded: Iterable[Effect], now: Iterable[Effect]) -> None:
        """Compare the decisions of one event at ``t``."""
        before, after = _decision(recorded), _decision(now)
        if before is None and after is None:
            return
        self.decisions += 1
        if before is None or after is None:
            self.one_sided += 1
            self._extend(t, _describe_decision(before), _describe_decision(after))
            return
        dv = abs(before.command.v - after.command.v)
        dw = abs(before.command.w - after.command.w)
        self.largest_v, self.largest_w = max(self.largest_v, dv), max(self.largest_w, dw)
        self.other_command += max(dv, dw) > ANOTHER_COMMAND
        self.other_action += before.action != after.action
        self.other_gate += before.gate_reason != after.gate_reason
        if before.action != after.action or before.gate_reason != after.gate_reason:
            self._extend(t, _describe_decision(before), _describe_decision(after))

    def _extend(self, t: float, recorded: str, now: str) -> None:
        last = self.episodes[-1] if self.episodes else None
        if (
            last is not None
            and (last.recorded, last.now) == (recorded, now)
            and t - last.end <= EPISODE_PAUSE_S
        ):
            last.end = t
        else:
            self.episodes.append(Episode(t, t, recorded, now))

    def lines(self, shown: int = 40) -> list[str]:
        """Return the comparison in lines for people, with at most ``shown`` episodes."""
        lines = [
            f"{self.decisions} decisions compared on the recorded inputs: "
            f"{self.other_action} another action, {self.other_gate} another word of the gate, "
            f"{self.other_command} another command "
            f"(by up to {self.largest_v:.2g} m/s, {self.largest_w:.2g} rad/s)"
        ]
        if self.one_sided:
            lines.append(f"{self.one_sided} decisions made only then or only now")
        lines += [
            f"  {episode.start:9.2f} to {episode.end:9.2f} s: {episode.recorded} -> {episode.now}"
            for episode in self.episodes[:shown]
        ]
        if len(self.episodes) > shown:
            lines.append(f"  and {len(self.episodes) - shown} more times")
        return lines


def _decision(effects: Iterable[Effect]) -> DecisionPayload | None:
    """Return the last decision among effects."""
    found = None
    for effect in effects:
        if isinstance(effect, Publish) and effect.stream == "decision":
            found = effect.payload
    if found is None:
        return None
    payload = decode("decision", found)
    assert isinstance(payload, DecisionPayload)
    return payload


def _describe_decision(decision: DecisionPayload | None) -> str:
    if decision is None:
        return "no decision"
    reason = decision.gate_reason
    held = f" ({GATE_WORDS.get(reason, reason)})" if reason else ""
    return decision.action.replace("_", " ") + held
