"""All outputs of an agent: the effects that ``Agent.handle`` returns, in order."""

from __future__ import annotations

from dataclasses import dataclass

from robot_agent.messages.events import LinkName


@dataclass(frozen=True, slots=True)
class Send:
    """Write bytes to a link."""

    link: LinkName
    data: bytes


@dataclass(frozen=True, slots=True)
class ChangeBaud:
    """Change a link's local baud rate once all bytes sent before are out."""

    link: LinkName
    baud: int


@dataclass(frozen=True, slots=True)
class Publish:
    """Publish one telemetry payload (JSON) to the operator and the recording."""

    stream: str
    payload: bytes


@dataclass(frozen=True, slots=True)
class TakePicture:
    """Request the camera's next picture as evidence; it arrives as a ``PictureTaken`` event."""


@dataclass(frozen=True, slots=True)
class Remember:
    """Store a ``RememberedPose`` (JSON) for the next start; ``{}`` deletes the stored one."""

    payload: bytes


Effect = Send | ChangeBaud | Publish | TakePicture | Remember
