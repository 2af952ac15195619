"""Holds of the gate too brief for a journal: at corners an obstacle holds a healthy robot often.

Telemetry and recording have every hold; only lines for people are fewer.
"""

from __future__ import annotations

from robot_agent.messages.foxglove import Log
from robot_agent.messages.streams import decode
from robot_agent.motion.gate_reason import GateReason
from robot_agent.motion.gate_words import GATE_WORDS

BRIEF_S = 2.0
"""A hold for an obstacle that ends sooner is no line. Ours: at corners they last up to 1 s."""
GATE = "gate"


class BriefHolds:
    """Passes on what is a line of the journal; a hold for an obstacle only once it has lasted."""

    def __init__(self) -> None:
        self._waiting: bytes | None = None
        self._since = 0.0
        self._unsaid = False

    def lines(self, payload: bytes, t: float) -> list[bytes]:
        """Return the payloads to be written, given a new one of the ``event`` stream at ``t`` s."""
        event = decode("event", payload)
        assert isinstance(event, Log)
        before = self.due(t)
        if event.name != GATE:
            return [*before, payload]
        self._waiting = None
        if event.message.endswith(f": {GATE_WORDS[GateReason.OBSTACLE]}"):
            self._waiting, self._since, self._unsaid = payload, t, True
            return before
        ends_unsaid = self._unsaid and event.message.startswith("lets")
        self._unsaid = False
        return before if ends_unsaid else [*before, payload]

    def due(self, t: float) -> list[bytes]:
        """Return a hold that has lasted until ``t`` s, once."""
        if self._waiting is None or t - self._since < BRIEF_S:
            return []
        lasting, self._waiting, self._unsaid = self._waiting, None, False
        return [lasting]
