"""The packets a client has asked an emulated controller to send beside its SIPs."""

from __future__ import annotations

from drivers.p2os.command_numbers import CommandNumber
from drivers.p2os.commands import Command

STREAM = 2
"""This argument and greater ones mean a packet in every cycle."""


class EmulatedStreams:
    """Remembers, of each kind asked for by its command number, whether one is due or many."""

    def __init__(self) -> None:
        self._wanted: dict[int, int] = {}

    def ask(self, command: Command) -> None:
        """Obey 0 stop, 1 one packet, 2 or more a stream."""
        self._wanted[command.number] = command.integer

    def stop(self) -> None:
        """Forget every request."""
        self._wanted.clear()

    def pop_due(self, number: CommandNumber) -> bool:
        """Tell whether a packet of a kind goes out in this cycle."""
        wanted = self._wanted.get(number, 0)
        if 0 < wanted < STREAM:
            self._wanted[number] = 0
        return wanted > 0
