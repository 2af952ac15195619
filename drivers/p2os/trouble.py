"""What can be wrong with a robot base, as a kind and in words with a remedy."""

from __future__ import annotations

from enum import StrEnum
from typing import NamedTuple


class TroubleKind(StrEnum):
    """Kind of trouble of a session with a base."""

    # No session yet
    NO_REPLY = "no reply"
    NOISE = "noise"  # something is heard, but no robot
    ECHO = "echo"
    OLD_SESSION = "old session"  # another client's, which does not end
    REFUSED = "handshake refused"
    OUT_OF_ORDER = "handshake out of order"
    # The session is lost
    SILENT = "silence"
    RESET = "reset"
    # In session
    MODEL = "model"
    LIMITS = "limits"
    STOP_BUTTON = "stop button"
    MOTORS_OFF = "motors off"


class Trouble(NamedTuple):
    """One trouble. words: one line for people with the remedy."""

    kind: TroubleKind
    words: str
