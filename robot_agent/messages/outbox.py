"""Queue of one event's outputs, in order: effects, and notices for people."""

from __future__ import annotations

from robot_agent.messages.effects import Effect
from robot_agent.messages.log_level import LogLevel
from robot_agent.messages.notice import Notice


class Outbox:
    """Collects effects and notices until the event has been handled."""

    def __init__(self) -> None:
        self._items: list[Effect | Notice] = []

    def add(self, *effects: Effect) -> None:
        """Append effects."""
        self._items += effects

    def log(self, t: float, part: str, words: str, level: LogLevel) -> None:
        """Append a notice of a part of the agent at t."""
        self._items.append(Notice(t, part, words, level))

    def pop_all(self) -> list[Effect | Notice]:
        """Return all items, in order, and empty the outbox."""
        items, self._items = self._items, []
        return items
