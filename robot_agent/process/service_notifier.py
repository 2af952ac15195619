"""What a service tells the system's manager: that it is ready, alive, and about to end.

The protocol of sd_notify(3): one datagram per message to the socket that NOTIFY_SOCKET names.
"""

from __future__ import annotations

import os
import socket
from collections.abc import Mapping


class ServiceNotifier:
    """Talks to systemd, or to nobody where the agent was not started as a service.

    ``period``: how often, s, ``alive`` is to be called; None if nobody watches.
    """

    def __init__(self, environment: Mapping[str, str] = os.environ) -> None:
        """Read where the manager listens and how patient it is."""
        address = environment.get("NOTIFY_SOCKET", "")
        self._address = f"\0{address[1:]}" if address.startswith("@") else address
        patience = environment.get("WATCHDOG_USEC", "") if address else ""
        self.period = int(patience) / 1e6 / 3.0 if patience.isdecimal() else None
        self._told_at = 0.0

    def ready(self) -> None:
        """The agent serves its devices, present or not."""
        self._send("READY=1\nSTATUS=patrolling agent started")

    def alive(self, t: float) -> None:
        """The control loop goes round at ``t``, s; tells it no more often than needed."""
        if self.period is not None and t - self._told_at >= self.period:
            self._told_at = t
            self._send("WATCHDOG=1")

    def stopping(self) -> None:
        """The agent was told to end."""
        self._send("STOPPING=1")

    def _send(self, message: str) -> None:
        """Send a datagram; a manager that does not listen is no reason to stop."""
        if not self._address:
            return
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC) as out:
            out.setblocking(False)
            try:
                out.sendto(message.encode(), self._address)
            except OSError:
                return
