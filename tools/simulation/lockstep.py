"""An agent wired to two emulated devices under a virtual clock, byte for byte."""

from __future__ import annotations

from typing import Protocol

from drivers.emulation.port import EmulatedDevice, garbled
from robot_agent.agent import Agent
from robot_agent.messages.effects import ChangeBaud, Effect, Send, TakePicture
from robot_agent.messages.events import (
    TICK_S,
    BytesReceived,
    Event,
    LinkName,
    LinkUp,
    OperatorKey,
    Shutdown,
    Tick,
)
from tools.simulation.lockstep_camera import LockstepCamera

BITS_PER_BYTE = 10


class Observer(Protocol):
    """Receives every event and effect in order, as the live recorder does."""

    def record_event(self, event: Event) -> None:
        """Take an event before it is handled."""

    def record_effect(self, t: float, effect: Effect) -> None:
        """Take an effect of the event at t."""


class LockstepAgent:
    """Delivers the devices' bytes to the agent at their wire times, and the agent's to them."""

    def __init__(
        self,
        agent: Agent,
        devices: dict[LinkName, EmulatedDevice],
        observer: Observer | None = None,
        camera: LockstepCamera | None = None,
    ) -> None:
        """Prepare the agent; nothing is delivered before ``start``."""
        self.agent = agent
        self._devices = devices
        self._observer = observer
        self._camera = camera
        self._local_baud: dict[LinkName, int] = {
            "base": agent.config.base.baud,
            "laser": agent.config.laser.baud,
        }
        self._next_tick = 0.0

    def start(self, t: float) -> None:
        """Open both links."""
        self._next_tick = t + TICK_S
        for link in self._devices:
            self._handle(LinkUp(round(t, 6), link))

    def deliver(self, t: float) -> None:
        """Deliver everything that arrives by t, and the ticks due by then, in order."""
        arrivals: list[Event] = [] if self._camera is None else self._camera.arrivals(t)
        for link, device in self._devices.items():
            self._handle_arrivals(link, device, t, arrivals)
        if len(arrivals) > 1:
            arrivals.sort(key=_time)
        for event in arrivals:
            self._tick_until(event.t)
            self._handle(event)
        self._tick_until(t)

    def press(self, t: float, ahead: int, left: int) -> None:
        """Deliver a drive key: ``ahead`` 0 or 1, ``left`` -1 to 1."""
        self._handle(OperatorKey(round(t, 6), ahead, left))

    def shut_down(self, t: float) -> None:
        """End the agent as SIGTERM does."""
        self._handle(Shutdown(round(t, 6)))

    def _handle_arrivals(
        self, link: LinkName, device: EmulatedDevice, t: float, arrivals: list[Event]
    ) -> None:
        """Handle what the line delivered by t, garbled where the rates differ."""
        while True:
            baud = device.baud  # a device may change its rate after a reply
            chunks = device.pop_output(t)
            if not chunks:
                return
            for chunk in chunks:
                data = self._over_line(link, chunk.data, baud)
                arrivals.append(BytesReceived(round(chunk.t, 6), link, data))

    def _over_line(self, link: LinkName, data: bytes, device_baud: int) -> bytes:
        return data if device_baud == self._local_baud[link] else garbled(data)

    def _tick_until(self, t: float) -> None:
        while self._next_tick <= t:
            self._handle(Tick(round(self._next_tick, 6)))
            self._next_tick += TICK_S

    def _handle(self, event: Event) -> None:
        if self._observer is not None:
            self._observer.record_event(event)
        for effect in self.agent.handle(event):
            if self._observer is not None:
                self._observer.record_effect(event.t, effect)
            self._carry_out(event.t, effect)

    def _carry_out(self, t: float, effect: Effect) -> None:
        match effect:
            case Send(link, data):
                self._send(t, link, data)
            case ChangeBaud(link, baud):
                self._local_baud[link] = baud
            case TakePicture():
                if self._camera is not None:
                    self._camera.request_picture()

    def _send(self, t: float, link: LinkName, data: bytes) -> None:
        device = self._devices[link]
        wire_time = len(data) * BITS_PER_BYTE / self._local_baud[link]
        device.feed(self._over_line(link, data, device.baud), t + wire_time)


def _time(event: Event) -> float:
    return event.t
