"""What happens in a session with a base, told once each: states, troubles and their ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from drivers.p2os.trouble import SEVERE, Trouble, TroubleKind

Severity = Literal["info", "warning", "error"]
SESSION = "session"
"""Subject of the states."""


@dataclass(frozen=True, slots=True)
class SessionEvent:
    """One thing that happened at ``t``. subject: SESSION, or the kind of trouble.

    words: one line for people, with the remedy of a trouble.
    """

    t: float
    subject: str
    words: str
    severity: Severity = "info"


class SessionEvents:
    """Collects events until they are taken; a trouble that lasts is told when it begins only."""

    def __init__(self) -> None:
        self._state: str | None = None
        self._present: frozenset[TroubleKind] = frozenset()
        self._events: list[SessionEvent] = []

    def note(self, t: float, words: str) -> None:
        """Tell something about the session itself."""
        self._events.append(SessionEvent(t, SESSION, words))

    def enter(self, t: float, state: str, words: str | None) -> None:
        """Tell that the session has come into a state, unless it was in it; None tells nothing."""
        if state != self._state and words is not None:
            self.note(t, words)
        self._state = state

    def update(self, t: float, troubles: Sequence[Trouble]) -> None:
        """Tell of the troubles that are new among those present, and of those that are over."""
        present = frozenset(trouble.kind for trouble in troubles)
        for kind, words in troubles:
            if kind not in self._present:
                severity: Severity = "error" if kind in SEVERE else "warning"
                self._events.append(SessionEvent(t, kind, words, severity))
        for kind in TroubleKind:
            if kind in self._present - present:
                self._events.append(SessionEvent(t, kind, "over"))
        self._present = present

    def forget_troubles(self) -> None:
        """Tell of no end: the line is down, and nobody knows."""
        self._present = frozenset()

    def pop(self) -> list[SessionEvent]:
        """Return and forget the events, oldest first."""
        events, self._events = self._events, []
        return events
