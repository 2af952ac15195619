"""Notifications of a service to systemd: ready, alive (watchdog), stopping.

The protocol of sd_notify(3): one datagram per message to the socket that NOTIFY_SOCKET names.
"""

from __future__ import annotations

import os
import socket
from collections.abc import Mapping

START_S = 180.0
"""s that a start may take before the manager ends it; a slow computer needs half a minute at boot
for the imports, and a start after failed ones waits as long."""


class ServiceNotifier:
    """Sends notifications to systemd; does nothing if the agent was not started as a service.

    ``period``: s within which ``alive`` is to be called; None without a watchdog.
    """

    def __init__(self, environment: Mapping[str, str] = os.environ) -> None:
        """Read the manager's socket and the watchdog's timeout from an environment."""
        address = environment.get("NOTIFY_SOCKET", "")
        self._address = f"\0{address[1:]}" if address.startswith("@") else address
        timeout_us = environment.get("WATCHDOG_USEC", "") if address else ""
        self.period = int(timeout_us) / 1e6 / 3.0 if timeout_us.isdecimal() else None
        self._sent_at = 0.0

    def starting(self, words: str = "starting") -> None:
        """Notify that the service is up, so that nobody waits for it; the agent follows.

        The watchdog has patience for START_S, until ``running``. words: status for people.
        """
        patience = f"\nWATCHDOG_USEC={START_S * 1e6:.0f}" if self.period is not None else ""
        self._send(f"READY=1\nSTATUS={words}{patience}")

    def running(self) -> None:
        """Notify that the agent runs, with its devices present or not; ``alive`` must follow."""
        patience = ""
        if self.period is not None:
            patience = f"\nWATCHDOG_USEC={self.period * 3e6:.0f}\nWATCHDOG=1"
        self._send(f"STATUS=patrolling agent started{patience}")

    def alive(self, t: float) -> None:
        """Trigger the watchdog if due at t; call in every cycle of the control loop."""
        if self.period is not None and t - self._sent_at >= self.period:
            self._sent_at = t
            self._send("WATCHDOG=1")

    def stopping(self) -> None:
        """Notify that the agent is about to end."""
        self._send("STOPPING=1")

    def _send(self, message: str) -> None:
        """Send a datagram; errors are ignored."""
        if not self._address:
            return
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC) as out:
            out.setblocking(False)
            try:
                out.sendto(message.encode(), self._address)
            except OSError:
                return
