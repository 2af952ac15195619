"""A base that ends its TCP connection when its client closes the session, as simulators do."""

from __future__ import annotations

from drivers.emulation.port import TcpPort
from drivers.p2os.emulator.emulator import P2osEmulator


class HangingUpPort:
    """Pumps a base's port and hangs up after CLOSE."""

    def __init__(self, port: TcpPort, base: P2osEmulator) -> None:
        self._port = port
        self._base = base

    def pump(self, t: float) -> None:
        """Move bytes both ways at ``t``, without waiting."""
        was_open = self._base.session_open
        self._port.pump(t)
        if was_open and not self._base.session_open:
            self._port.hang_up()
