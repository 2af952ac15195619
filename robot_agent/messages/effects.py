"""Everything an agent can do to the world, returned by ``Agent.handle`` in order."""

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
    """Change a link's local rate after everything sent before has left."""

    link: LinkName
    baud: int


@dataclass(frozen=True, slots=True)
class Publish:
    """Hand one telemetry payload (JSON) to the operator and the recording."""

    stream: str
    payload: bytes


@dataclass(frozen=True, slots=True)
class TakePicture:
    """Have the camera's next picture sent, as evidence; ``PictureTaken`` brings it."""


@dataclass(frozen=True, slots=True)
class Remember:
    """Keep this for the next start: a ``RememberedPose`` as JSON; ``{}``: none is sure any more."""

    payload: bytes


Effect = Send | ChangeBaud | Publish | TakePicture | Remember
