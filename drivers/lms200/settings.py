"""Settings of the laser."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

RESOLUTIONS_DEG = (1.0, 0.5)


class LaserSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where the laser is and how it shall run.

    url: serial device, pty path, or socket://host:port
    baud: rate to run at; 500000 needs RS-422
    resolution_deg: 1.0 (181 beams) or 0.5 (361 beams in two interlaced turns)
    mount: laser in base_link, (x m, y m, theta rad); None takes it from the robot's model
    silence: s without a scan after which the laser is looked for again
    """

    url: str = "/dev/ttyS2"
    baud: Literal[9600, 19200, 38400, 500000] = 38400
    resolution_deg: float = 1.0
    mount: tuple[float, float, float] | None = None
    silence: Annotated[float, msgspec.Meta(gt=0.0)] = 2.0

    def __post_init__(self) -> None:
        if self.resolution_deg not in RESOLUTIONS_DEG:
            raise ValueError(f"resolution_deg is 1.0 or 0.5, not {self.resolution_deg}")
