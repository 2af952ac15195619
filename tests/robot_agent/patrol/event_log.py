"""An observer of an agent that keeps its events."""

from robot_agent.messages.effects import Publish


class EventLog:
    """Keeps the events an agent publishes: (t, words)."""

    def __init__(self):
        self.lines = []

    def record_event(self, event):
        pass

    def record_effect(self, t, effect):
        if isinstance(effect, Publish) and effect.stream == "event":
            self.lines.append((t, effect.payload.decode()))
