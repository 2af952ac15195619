"""Log messages for people about overrides of the paper's choice."""

from __future__ import annotations

from robot_agent.messages.log_level import LogLevel
from robot_agent.patrol.actions import Action
from robot_agent.patrol.modifier import OverrideReason
from robot_agent.patrol.patrol import PatrolDecision

_PART = "patrol"


def override_notice(
    decision: PatrolDecision, before: PatrolDecision | None
) -> tuple[str, str, LogLevel] | None:
    """Return (part, text, level) of the log message if an override begins; None if none is due."""
    reason = decision.override
    if reason is None or (before is not None and before.override is reason):
        return None
    place = f"near s = {decision.abscissa:.1f} m"
    match reason:
        case OverrideReason.BLOCKAGE:
            turned = "" if decision.turn is None else ", turns back"
            return _PART, f"unknown object {place} holds the robot{turned}", LogLevel.WARNING
        case OverrideReason.CLOSING_IN:
            words = f"comes closer to a teammate {place} that always sent it back there"
            return _PART, words, LogLevel.INFO
        case OverrideReason.STANDOFF:
            return "standoff", _standoff_words(decision, place), LogLevel.INFO
        case _:
            return None


def _standoff_words(decision: PatrolDecision, place: str) -> str:
    match decision.action:
        case Action.REACH_FRONTIER:
            return f"kept from the border {place} for too long, drives to it"
        case Action.KEEP_GOING:
            return f"avoided teammates {place} for too long, goes on"
        case _:
            return f"caught at the border's end {place} for too long, leaves it"
