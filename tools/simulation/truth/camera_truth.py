"""The camera of a simulated robot, and the band that robots carry."""

from __future__ import annotations

from typing import Annotated

import msgspec

Length = Annotated[float, msgspec.Meta(gt=0.0)]
Pixels = Annotated[int, msgspec.Meta(ge=16, le=4096)]


class CameraTruth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A camera that looks level."""

    width: Pixels
    height: Pixels
    focal_length: Length  # pixels
    mount: tuple[float, float, float]  # x, y (m) and theta (rad) in base_link
    mount_height: Length  # m, of the lens above the floor


class BandTruth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The coloured band round a robot."""

    middle: Length  # m above the floor
    height: Length  # m, from edge to edge
