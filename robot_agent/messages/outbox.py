"""Queue of one event's outputs, in order: effects, and notices for people."""

from __future__ import annotations

from collections.abc import Sequence

from drivers.requests import Request, Write
from robot_agent.messages.effects import ChangeBaud, Effect, Publish, Send
from robot_agent.messages.events import LinkName
from robot_agent.messages.notice import Notice
from robot_agent.messages.streams import Payload, encode


class Outbox:
    """Collects effects and notices until the event has been handled."""

    def __init__(self) -> None:
        self._items: list[Effect | Notice] = []

    def add(self, *items: Effect | Notice) -> None:
        """Append effects and notices."""
        self._items += items

    def request(self, link: LinkName, requests: Sequence[Request]) -> None:
        """Append what a device session asks of its link."""
        for request in requests:
            if isinstance(request, Write):
                self._items.append(Send(link, request.data))
            else:
                self._items.append(ChangeBaud(link, request.baud))

    def publish(self, payloads: Sequence[tuple[str, Payload]]) -> None:
        """Append payloads, each with the name of its stream."""
        self._items += published(payloads)

    def pop_all(self) -> list[Effect | Notice]:
        """Return all items, in order, and empty the outbox."""
        items, self._items = self._items, []
        return items


def published(payloads: Sequence[tuple[str, Payload]]) -> list[Publish]:
    """Return the effects that publish payloads, each with the name of its stream."""
    return [Publish(stream, encode(payload)) for stream, payload in payloads]
