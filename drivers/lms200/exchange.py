"""One command to the laser and its reply: tries, deadline, detection of noise.

Source: SICK telegram listing 8007954/Q501, acknowledgement and timing.
"""

from __future__ import annotations

from drivers.lms200.framing import MAX_PAYLOAD, OVERHEAD, TelegramFramer, encode_telegram

TRIES = 3  # the laser may miss a request while its mirror turns
ACK_LIMIT = 0.25  # s from the last byte to the ACK; 60 ms in the listing, the rest is margin
NAK_PAUSE = 0.03  # s before a refused telegram may be repeated

_BITS_PER_BYTE = 10


class Exchange:
    """A command in progress. The owner writes what ``send`` returns and acts at ``deadline``.

    ``is_acknowledged`` by the laser: its reply is due.
    """

    def __init__(self, framer: TelegramFramer) -> None:
        self.command = b""
        self.deadline = 0.0
        self.tries_left = 0
        self.is_acknowledged = False
        self._framer = framer
        self._reply_limit = 0.0
        self._latest_ack = 0.0
        self._good_before = 0
        self._noise_before = 0

    def begin(self, command: bytes, reply_limit: float) -> None:
        """Set the next command; its reply is due within ``reply_limit`` (s) of the ACK."""
        self.command = command
        self.tries_left = TRIES
        self._reply_limit = reply_limit

    def send(self, t: float, baud: int) -> bytes:
        """Return the frame to write now."""
        self.tries_left -= 1
        self.is_acknowledged = False
        self._good_before = self._framer.counters.good
        self._noise_before = self._framer.counters.discarded_bytes
        self.deadline = t + ACK_LIMIT
        longest_frame = (MAX_PAYLOAD + OVERHEAD) * _BITS_PER_BYTE / baud
        self._latest_ack = self.deadline + longest_frame
        return encode_telegram(self.command)

    def on_bytes(self, t: float) -> None:
        """Extend the deadline: the bytes may be a scan, which delays the ACK."""
        self.deadline = max(self.deadline, min(t + ACK_LIMIT, self._latest_ack))

    def acknowledged(self, t: float) -> None:
        """Set the deadline for the reply after an ACK."""
        self.is_acknowledged = True
        self.deadline = t + self._reply_limit

    def refused(self, t: float) -> None:
        """Set the deadline after a NAK, at which the command is repeated."""
        self.deadline = t + NAK_PAUSE

    @property
    def amid_noise(self) -> bool:
        """Whether bytes were discarded since the command was sent: an ACK may then be noise too."""
        return self._framer.counters.discarded_bytes != self._noise_before

    @property
    def heard(self) -> bool:
        """Whether an ACK or a telegram has come since the command was sent."""
        return self.is_acknowledged or self._framer.counters.good != self._good_before

    @property
    def only_noise(self) -> bool:
        """Whether bytes arrived but no telegram: most likely sent at another rate."""
        received = self._framer.pending or self.amid_noise
        return received and self._framer.counters.good == self._good_before
