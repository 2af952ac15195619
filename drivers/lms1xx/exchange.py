"""One command to the scanner and its reply: tries and deadline."""

from __future__ import annotations

from drivers.lms1xx.framing import Dialect, Telegram, encode_telegram
from drivers.lms1xx.telegrams import decode_fault, reply_to

TRIES = 2  # a connection loses nothing; the second is for a scanner that was busy


class Exchange:
    """A command in progress. The owner writes what ``send`` returns and acts at ``deadline``."""

    def __init__(self) -> None:
        self.deadline = 0.0
        self.tries_left = 0
        self.command = ""
        """Kind and name, e.g. ``sRN DeviceIdent``."""
        self._payload = b""
        self._reply_limit = 0.0

    def begin(self, command: str, payload: bytes, reply_limit: float, tries: int = TRIES) -> None:
        """Set the next command; its reply is due within ``reply_limit`` (s)."""
        self.command = command
        self._payload = payload
        self._reply_limit = reply_limit
        self.tries_left = tries

    def send(self, t: float, dialect: Dialect) -> bytes:
        """Return the frame to write now."""
        self.tries_left -= 1
        self.deadline = t + self._reply_limit
        return encode_telegram(self._payload, dialect)

    def is_reply(self, telegram: Telegram) -> bool:
        """Return whether a telegram is the reply, or a refusal, which does not say of what."""
        expected = reply_to(self.command)
        return telegram.command == expected or decode_fault(telegram) is not None
