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

    def pop_due(self, number: CommandNumber) -> bool:
        """Return whether a packet is sent in this cycle; clears a request for one packet."""
        wanted = self._wanted.get(number, 0)
        if 0 < wanted < STREAM:
            self._wanted[number] = 0
        return wanted > 0
