"""A tap on a base's line that decodes the motion orders."""

from __future__ import annotations

import math

from drivers.emulation.port import EmulatedDevice
from drivers.emulation.timed_bytes import TimedBytes
from drivers.p2os.command_numbers import CommandNumber
from drivers.p2os.commands import decode_command
from drivers.p2os.framing import PacketFramer

_STANDING_ORDERS = frozenset((CommandNumber.STOP, CommandNumber.E_STOP, CommandNumber.CLOSE))


class OrderTap:
    """Decodes the client's commands on their way to a base; knows whether they order standstill.

    ``first_order`` is the first motion order since ``forget``, by name, at ``first_at``; OPEN
    clears it, because orders without a session have no effect.
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
        """Number of sessions opened."""
        self.last_at = 0.0
        """Time of the client's last bytes; 0 before the first."""
        self.response_times: list[float] = []
        self._last_output: float | None = None

    @property
    def baud(self) -> int:
        """The device's present rate."""
        return self._device.baud

    @property
    def is_standing(self) -> bool:
        """Whether the last orders mean standstill."""
        return self._speed == 0 and self._turn_rate == 0

    def forget(self) -> None:
        """Clear the first order."""
        self.first_order, self.first_at = "", math.inf

    def feed(self, data: bytes, t: float) -> None:
        """Decode bytes from the client and pass them on."""
        self.last_at = t
        for packet in self._framer.feed(data):
            self._read(packet, t)
        self._device.feed(data, t)

    def pop_output(self, t: float) -> list[TimedBytes]:
        """Return what has left the device by ``t``."""
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
        """Store the response time of a changed order; a repeated one does not count."""
        if is_new and self._last_output is not None:
            self.response_times.append(t - self._last_output)
            self._last_output = None

    def _note(self, order: str, t: float) -> None:
        if not self.first_order:
            self.first_order, self.first_at = order, t
