"""The service manager's part for an agent: how long its watchdog is left without food."""

from __future__ import annotations

import socket
from collections.abc import Mapping
from contextlib import suppress
from itertools import pairwise
from pathlib import Path

WATCHDOG_S = 3.0
"""As in the unit."""
_LONGEST_MESSAGE = 4096


class ServiceWatch:
    """Listens to the notifications of an agent started with ``environment``."""

    def __init__(self, folder: Path) -> None:
        path = folder / "notify"
        self.environment: Mapping[str, str] = {
            "NOTIFY_SOCKET": str(path),
            "WATCHDOG_USEC": f"{WATCHDOG_S * 1e6:.0f}",
        }
        self._fed: list[float] = []
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(str(path))
        self._socket.setblocking(False)

    def step(self, t: float) -> None:
        """Take what has come by t."""
        with suppress(BlockingIOError):
            while True:
                if b"WATCHDOG=1" in self._socket.recv(_LONGEST_MESSAGE):
                    self._fed.append(t)

    def longest_hunger(self, begun: float, ended: float) -> float:
        """Return the longest time without food between two times, s."""
        fed = [begun, *(t for t in self._fed if begun < t < ended), ended]
        return max(after - before for before, after in pairwise(fed))

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()
