"""A recorder of an agent's events and effects, for tests."""

from __future__ import annotations

from drivers.p2os.commands import decode_command
from drivers.p2os.framing import PacketFramer
from robot_agent.messages.effects import Effect, Publish, Send
from robot_agent.messages.events import Event
from robot_agent.messages.foxglove import Log
from robot_agent.messages.streams import decode


class Tape:
    """Records the events and effects of an agent."""

    def __init__(self) -> None:
        self.steps: list[tuple[Event, list[Effect]]] = []

    def record_event(self, event: Event) -> None:
        self.steps.append((event, []))

    def record_effect(self, _t: float, effect: Effect) -> None:
        self.steps[-1][1].append(effect)

    def effects(self) -> list[Effect]:
        return [effect for _, effects in self.steps for effect in effects]

    def logs(self) -> list[Log]:
        events = [e for e in self.effects() if isinstance(e, Publish) and e.stream == "event"]
        decoded = [decode(event.stream, event.payload) for event in events]
        return [log for log in decoded if isinstance(log, Log)]

    def news(self) -> list[str]:
        return [log.message for log in self.logs()]

    def logged(self, part: str) -> list[str]:
        return [log.message for log in self.logs() if log.name == part]

    def sent_to_base(self) -> list[tuple[int, int | None]]:
        framer = PacketFramer()
        packets = framer.feed(
            b"".join(e.data for e in self.effects() if isinstance(e, Send) and e.link == "base")
        )
        return [(c.number, c.integer) for c in map(decode_command, packets)]
