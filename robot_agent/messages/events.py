"""All inputs of an agent, whose behaviour is a function of a list of these events.

Times count from the agent's start on a monotonic clock, in whole microseconds (``round(t, 6)``), so
that a recording reproduces them exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from robot_agent.messages.blob import Blob, Sight

LinkName = Literal["base", "laser"]
"""Devices the agent exchanges bytes with."""
DeviceName = Literal["base", "laser", "camera"]
"""Devices that may be connected or not."""

TICK_S = 0.05
"""s between two ticks, unless the agent is overloaded."""


@dataclass(frozen=True, slots=True)
class BytesReceived:
    """Bytes that arrived on a link; t is when the last of them was read."""

    t: float
    link: LinkName
    data: bytes


@dataclass(frozen=True, slots=True)
class LinkUp:
    """A link's port was opened, or the camera delivers pictures."""

    t: float
    link: DeviceName


@dataclass(frozen=True, slots=True)
class LinkDown:
    """A link's port, or the camera, could not be opened or was lost."""

    t: float
    link: DeviceName
    reason: str


@dataclass(frozen=True, slots=True)
class BlobsSeen:
    """Bands detected in a picture taken at ``taken``; t: when the detection was complete."""

    t: float
    taken: float
    sight: Sight
    blobs: tuple[Blob, ...]


@dataclass(frozen=True, slots=True)
class PictureTaken:
    """A picture the agent requested, as JPEG, taken at ``taken``."""

    t: float
    taken: float
    jpeg: bytes


@dataclass(frozen=True, slots=True)
class Tick:
    """Time has passed (20 Hz); drives timeouts."""

    t: float


@dataclass(frozen=True, slots=True)
class Shutdown:
    """The process is to end: stop the robot and close both sessions."""

    t: float


@dataclass(frozen=True, slots=True)
class OperatorKey:
    """A key typed at the robot's own terminal: a short driving command.

    ahead: 1 forwards, 0 not; left: 1 turn left, -1 right, 0 straight.
    """

    t: float
    ahead: int
    left: int


Event = BytesReceived | LinkUp | LinkDown | BlobsSeen | PictureTaken | Tick | Shutdown | OperatorKey
