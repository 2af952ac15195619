"""What the agent has to be done about one event: bytes to send, payloads to publish, pictures."""

from __future__ import annotations

from drivers.requests import Request, Write
from robot_agent.messages.effects import ChangeBaud, Effect, Publish, Send
from robot_agent.messages.events import LinkName
from robot_agent.messages.foxglove import LogLevel
from robot_agent.messages.streams import Payload, encode
from robot_agent.report.telemetry_builder import Reports


class Outbox:
    """Collects effects in their order; who publishes nothing still sends."""

    def __init__(self, reports: Reports, *, publishes: bool) -> None:
        """Take what builds the news, and whether anybody is told at all."""
        self._reports = reports
        self.publishes = publishes
        self._effects: list[Effect] = []

    def take(self) -> list[Effect]:
        """Return what has been collected, and begin anew."""
        effects, self._effects = self._effects, []
        return effects

    def add(self, effect: Effect) -> None:
        """Add an effect as it is."""
        self._effects.append(effect)

    def publish(self, payloads: list[tuple[str, Payload]]) -> None:
        """Add payloads, each with the name of its stream."""
        self._effects += [Publish(stream, encode(payload)) for stream, payload in payloads]

    def say(self, t: float, part: str, words: str, level: LogLevel) -> None:
        """Tell what a part of the agent has to say at t, s, if that is news."""
        if self.publishes:
            self.publish(self._reports.on_news(t, part, words, level))

    def carry_out(self, link: LinkName, requests: list[Request]) -> None:
        """Turn a session's requests into effects."""
        for request in requests:
            if isinstance(request, Write):
                self._effects.append(Send(link, request.data))
            else:
                self._effects.append(ChangeBaud(link, request.baud))
