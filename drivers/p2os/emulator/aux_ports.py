"""The auxiliary serial ports of an emulated controller.

Source: Pioneer 2 and H8-series manuals, TTY2 and GETAUX: bytes of a TTY command leave at once;
those that arrive are kept, and sent to the client once as many are there as it has asked for.
"""

from __future__ import annotations

from drivers.p2os.extended_packets import AuxPacket

PORTS = (1, 2, 3)
LARGEST_REQUEST = 200
"""Most bytes of one SERAUX packet."""
KEPT = 200
"""Bytes kept of what arrives; later ones push out the oldest. Ours."""


class AuxPort:
    """One port: an attached device puts bytes in by ``receive``.

    loop_back: whether a plug returns what is sent; else that is lost.
    """

    def __init__(self, number: int) -> None:
        self.loop_back = False
        self._number = number
        self._arrived = bytearray()
        self._requested = 0

    def receive(self, data: bytes) -> None:
        """Take bytes from the attached device."""
        self._arrived += data
        del self._arrived[:-KEPT]

    def send(self, data: bytes) -> None:
        """Send a client's bytes out of the port."""
        if self.loop_back:
            self.receive(data)

    def request(self, size: int) -> None:
        """Ask for bytes, at most LARGEST_REQUEST; 0 discards those that wait."""
        self._requested = min(max(size, 0), LARGEST_REQUEST)
        if not self._requested:
            self._arrived.clear()

    def cancel(self) -> None:
        """Forget the request; the session is over."""
        self._requested = 0

    def pop_answer(self) -> AuxPacket | None:
        """Return the bytes asked for once they are there; None as long as they are not."""
        size = self._requested
        if not 0 < size <= len(self._arrived):
            return None
        answer = AuxPacket(self._number, bytes(self._arrived[:size]))
        del self._arrived[:size]
        self._requested = 0
        return answer
