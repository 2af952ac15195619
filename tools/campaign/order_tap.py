"""A tap on a base's line that knows whether the base is told to stand or to move."""

from __future__ import annotations

import math

from drivers.emulation.port import EmulatedDevice
from drivers.emulation.timed_bytes import TimedBytes
from drivers.p2os.command_numbers import CommandNumber
from drivers.p2os.commands import decode_command
from drivers.p2os.framing import PacketFramer

_STANDING_ORDERS = frozenset((CommandNumber.STOP, CommandNumber.E_STOP, CommandNumber.CLOSE))


class OrderTap:
    """Listens to what a base is told, and knows whether it is to stand or to move.

    ``first_order`` is the first motion order since ``forget``, by name, at ``first_at`` (s). A
    client that opens a session starts that watch anew: what it sent without one moved nothing.
    ``response_times`` are the times, s, from the device's last byte to the first new order.
    """

    def __init__(self, device: EmulatedDevice) -> None:
        self._device = device
        self._framer = PacketFramer()
        self._speed = 0
        self._turn_rate = 0
        self.first_order = ""
        self.first_at = math.inf
        self.sessions = 0
        """How many a client has opened."""
        self.last_at = 0.0
        """When the client last said anything, s; 0 before it has."""
        self.response_times: list[float] = []
        self._last_output: float | None = None

    @property
    def baud(self) -> int:
        """The device's present rate."""
        return self._device.baud

    @property
    def told_to_stand(self) -> bool:
        """Whether the last orders amount to standstill."""
        return self._speed == 0 and self._turn_rate == 0

    def forget(self) -> None:
        """Begin a new watch for the first order."""
        self.first_order, self.first_at = "", math.inf

    def feed(self, data: bytes, t: float) -> None:
        """Pass on bytes from the client, and read them."""
        self.last_at = t
        for packet in self._framer.feed(data):
            self._read(packet, t)
        self._device.feed(data, t)

    def pop_output(self, t: float) -> list[TimedBytes]:
        """Pass on what has left the device."""
        output = self._device.pop_output(t)
        if output:
            self._last_output = t
        return output

    def _read(self, packet: bytes, t: float) -> None:
        command = decode_command(packet)
        number, value = command.number, command.integer
        if number == CommandNumber.OPEN:
            self.sessions += 1
            self.forget()
        elif number == CommandNumber.VEL:
            self._time_response(t, is_new=value != self._speed)
            self._speed = value
            self._note(f"VEL {value}", t)
        elif number == CommandNumber.RVEL:
            self._time_response(t, is_new=value != self._turn_rate)
            self._turn_rate = value
            self._note(f"RVEL {value}", t)
        elif number == CommandNumber.ENABLE:
            self._on_enable(value, t)
        elif number in _STANDING_ORDERS:
            self._speed = self._turn_rate = 0
            self._note(CommandNumber(number).name, t)

    def _on_enable(self, value: int, t: float) -> None:
        if not value:
            self._speed = self._turn_rate = 0
        self._note(f"ENABLE {value}", t)

    def _time_response(self, t: float, *, is_new: bool) -> None:
        """Note how long a new order took; one sent again to keep the watchdog quiet is none."""
        if is_new and self._last_output is not None:
            self.response_times.append(t - self._last_output)
            self._last_output = None

    def _note(self, order: str, t: float) -> None:
        if not self.first_order:
            self.first_order, self.first_at = order, t
