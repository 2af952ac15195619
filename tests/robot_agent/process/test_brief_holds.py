"""Which of the gate's holds become lines of the journal."""

from __future__ import annotations

from robot_agent.messages.foxglove import Log, timestamp_at
from robot_agent.messages.log_level import LogLevel
from robot_agent.messages.streams import encode
from robot_agent.motion.gate_reason import GateReason
from robot_agent.motion.gate_words import GATE_WORDS
from robot_agent.process.brief_holds import BriefHolds


def event(message: str, name: str = "gate") -> bytes:
    return encode(Log(timestamp=timestamp_at(0.0), level=LogLevel.INFO, message=message, name=name))


HELD, STALE = (
    event(f"holds the robot: {GATE_WORDS[reason]}")
    for reason in (GateReason.OBSTACLE, GateReason.STALE_LASER)
)
MOVES, OTHER = event("lets the robot move"), event("localized", "localization")


def test_a_brief_hold_is_no_line() -> None:
    holds = BriefHolds()
    assert holds.lines(HELD, 10.0) == []
    assert holds.lines(OTHER, 10.5) == [OTHER]
    assert holds.lines(MOVES, 11.0) == []
    assert holds.due(20.0) == []


def test_a_lasting_hold_is_a_line_once_and_so_is_its_end() -> None:
    holds = BriefHolds()
    assert holds.lines(HELD, 10.0) == []
    assert holds.due(11.9) == []
    assert holds.due(12.0) == [HELD]
    assert holds.due(13.0) == []
    assert holds.lines(MOVES, 14.0) == [MOVES]


def test_a_lasting_hold_is_told_before_what_comes_after_it() -> None:
    holds = BriefHolds()
    assert holds.lines(HELD, 10.0) == []
    assert holds.lines(OTHER, 12.5) == [HELD, OTHER]
    assert holds.lines(MOVES, 12.6) == [MOVES]


def test_any_other_hold_is_told_at_once_and_so_is_its_end() -> None:
    holds = BriefHolds()
    assert holds.lines(HELD, 10.0) == []
    assert holds.lines(STALE, 10.1) == [STALE]
    assert holds.lines(MOVES, 10.2) == [MOVES]
    assert holds.due(20.0) == []


def test_holds_that_follow_each_other_count_one_by_one() -> None:
    holds = BriefHolds()
    for t in (10.0, 11.5, 13.0):
        assert holds.lines(HELD, t) == []
        assert holds.lines(MOVES, t + 1.0) == []
