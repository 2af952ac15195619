"""Everything that can happen to an agent. An agent's behaviour is a function of a list of these.

Times are seconds since the agent's start on a monotonic clock, in whole microseconds
(``round(t, 6)``), so that a recording reproduces them exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from robot_agent.messages.blob import Blob, Sight

LinkName = Literal["base", "laser"]
"""What the agent exchanges bytes with."""
DeviceName = Literal["base", "laser", "camera"]
"""What can be plugged in or not."""

TICK_S = 0.05
"""Between two ticks, while the agent keeps up."""


@dataclass(frozen=True, slots=True)
class BytesReceived:
    """Bytes that arrived on a link; t is when the last of them was read."""

    t: float
    link: LinkName
    data: bytes


@dataclass(frozen=True, slots=True)
class LinkUp:
    """A link's port was opened, or the camera gives pictures."""

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
    """What a picture taken at ``taken`` (s) showed of the team's colour; found before t."""

    t: float
    taken: float
    sight: Sight
    blobs: tuple[Blob, ...]


@dataclass(frozen=True, slots=True)
class PictureTaken:
    """A picture the agent asked for, as JPEG, taken at ``taken`` (s)."""

    t: float
    taken: float
    jpeg: bytes


@dataclass(frozen=True, slots=True)
class Tick:
    """Time passed (20 per second); lets silence be noticed."""

    t: float


@dataclass(frozen=True, slots=True)
class Shutdown:
    """The process was told to end: stop the robot and close both sessions."""

    t: float


@dataclass(frozen=True, slots=True)
class OperatorKey:
    """A key typed at the robot's own terminal: where to drive, for a moment.

    ahead: 1 forwards, 0 not; left: 1 turn left, -1 right, 0 straight.
    """

    t: float
    ahead: int
    left: int


Event = BytesReceived | LinkUp | LinkDown | BlobsSeen | PictureTaken | Tick | Shutdown | OperatorKey
