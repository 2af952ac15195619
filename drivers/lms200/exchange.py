"""One command to the laser and the wait for its reply: tries, deadline, signs of noise.

Source: SICK telegram listing 8007954/Q501, acknowledgement and timing.
"""

from __future__ import annotations

from drivers.lms200.framing import MAX_PAYLOAD, OVERHEAD, TelegramFramer, encode_telegram

TRIES = 3  # the laser may overlook a request while its mirror turns
ACK_LIMIT = 0.25  # s from the last byte of the line to the ACK: 60 ms by the listing, and our own
NAK_PAUSE = 0.03  # s before a refused telegram may be repeated

_BITS_PER_BYTE = 10


class Exchange:
    """A command under way. The owner writes what ``send`` returns and acts at the ``deadline``."""

    def __init__(self, framer: TelegramFramer) -> None:
        self.command = b""
        self.deadline = 0.0
        self.tries_left = 0
        self._framer = framer
        self._reply_limit = 0.0
        self._latest_ack = 0.0
        self._good_before = 0
        self._noise_before = 0

    def begin(self, command: bytes, reply_limit: float) -> None:
        """Take the next command; its reply comes within ``reply_limit`` (s) of the ACK."""
        self.command = command
        self.tries_left = TRIES
        self._reply_limit = reply_limit

    def send(self, t: float, baud: int) -> bytes:
        """Return the frame to write now."""
        self.tries_left -= 1
        self._good_before = self._framer.counters.good
        self._noise_before = self._framer.counters.discarded_bytes
        self.deadline = t + ACK_LIMIT
        longest_frame = (MAX_PAYLOAD + OVERHEAD) * _BITS_PER_BYTE / baud
        self._latest_ack = self.deadline + longest_frame
        return encode_telegram(self.command)

    def bytes_came(self, t: float) -> None:
        """Something arrives: a scan may be on its way, the ACK comes after it."""
        self.deadline = max(self.deadline, min(t + ACK_LIMIT, self._latest_ack))

    def acknowledged(self, t: float) -> None:
        """The laser has understood: it replies."""
        self.deadline = t + self._reply_limit

    def refused(self, t: float) -> None:
        """The laser has not understood: repeat at the deadline."""
        self.deadline = t + NAK_PAUSE

    @property
    def amid_noise(self) -> bool:
        """Whether bytes since the command was sent made no sense: a lone ACK may be one too."""
        return self._framer.counters.discarded_bytes != self._noise_before

    @property
    def only_noise(self) -> bool:
        """Whether bytes came and none made a telegram: most likely sent at another rate."""
        heard = self._framer.pending or self.amid_noise
        return heard and self._framer.counters.good == self._good_before
