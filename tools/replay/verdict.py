"""What a check of a recording came to."""

from __future__ import annotations

from enum import Enum

from tools.replay.replay import ReplayResult
from tools.replay.what_if import ANOTHER_COMMAND, WhatIf


class Verdict(Enum):
    """How a replay agrees with its recording."""

    IDENTICAL = "identical"
    """Every effect, to the last bit."""
    EQUAL_IN_DECISIONS = "equal in decisions"
    """On a computer that rounds differently: all decisions, with commands within a bound."""
    DIFFERENT = "different"


def verdict(result: ReplayResult, what_if: WhatIf | None) -> tuple[Verdict, str]:
    """Return the verdict on a checked replay, with its words for people.

    what_if: comparison with the recorded decisions; None on a computer that rounds as the recording
    one, where all must be identical.
    """
    if result.events == 0:
        return Verdict.DIFFERENT, "nothing to compare: the recording holds no event there"
    counts = f"{result.events} events, {result.decisions} decisions"
    if result.difference is None:
        return Verdict.IDENTICAL, f"identical: {counts}, {result.bytes_sent} bytes"
    if what_if is None or result.records_lost or not what_if.equal:
        return Verdict.DIFFERENT, result.difference
    bound = f"commands within {ANOTHER_COMMAND} m/s and rad/s"
    return (
        Verdict.EQUAL_IN_DECISIONS,
        f"{result.difference}\nequal in decisions: {counts}, {bound}",
    )
