"""Packets that a client has requested from an emulated controller beside its SIPs."""

from __future__ import annotations

from drivers.p2os.command_numbers import CommandNumber
from drivers.p2os.commands import Command

STREAM = 2
"""Smallest argument that means a packet in every cycle."""


class EmulatedStreams:
    """Requests by command number: none, one packet or a stream."""

    def __init__(self) -> None:
        self._wanted: dict[int, int] = {}

    def request(self, command: Command) -> None:
        """Set the request: 0 stop, 1 one packet, 2 or more a stream."""
        self._wanted[command.number] = command.integer

    def stop(self) -> None:
        """Clear all requests."""
        self._wanted.clear()

    def due(self, cycle: int) -> list[CommandNumber]:
        """Return the requests for which a packet is due, another one first in each cycle."""
        wanted = [CommandNumber(number) for number, value in self._wanted.items() if value > 0]
        first = cycle % len(wanted) if wanted else 0
        return wanted[first:] + wanted[:first]

    def on_sent(self, number: CommandNumber) -> None:
        """Note that a packet was sent: a request for one is fulfilled."""
        if self._wanted[number] < STREAM:
            self._wanted[number] = 0
