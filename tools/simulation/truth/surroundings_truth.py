"""What the simulated building really is: surfaces, floor, people, and what no map shows."""

from __future__ import annotations

import math
from typing import Annotated

import msgspec

NotNegative = Annotated[float, msgspec.Meta(ge=0.0)]
Share = Annotated[float, msgspec.Meta(ge=0.0, le=1.0)]
Count = Annotated[int, msgspec.Meta(ge=0, le=100)]
SteepAngle = Annotated[float, msgspec.Meta(gt=0.0, le=math.pi / 2)]


class SurfaceTruth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One kind of surface, as a laser measures it; which stretch of wall has it, the seed draws.

    share: of the walls. offset: m, systematic. noise: standard deviation of one range at once
    before the laser, m. reach: m, farther away nothing returns. facing: rad, the largest angle
    between a beam and the surface's normal at which something returns. glare: rad, the largest one
    at which it passes for a reflector; 0 for never.
    """

    share: Share
    offset: float
    noise: NotNegative
    reach: float
    facing: SteepAngle
    glare: NotNegative


class OpticsTruth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How lasers see the building.

    surfaces: by name; empty for none, so all walls have the noise of the world alone. mixed: share
    of the beams at an edge that return a range between the near and the far one.
    """

    surfaces: dict[str, SurfaceTruth]
    mixed: Share


class SonarTruth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How sonars hear the building.

    half_cone: rad, of the beam. rays: odd, cast over the cone. critical: rad, the angle between a
    flat surface's normal and the axis of a transducer beyond which the surface is a mirror;
    mirrors: share of these that send nothing back. false_echoes: share of readings that are
    nothing but noise. crosstalk: share of readings that are a neighbour's echo.
    """

    half_cone: SteepAngle
    rays: Annotated[int, msgspec.Meta(ge=3, le=15)]
    critical: SteepAngle
    mirrors: Share
    false_echoes: Share
    crosstalk: Share

    def __post_init__(self) -> None:
        if self.rays % 2 == 0:
            raise ValueError("rays is even; use an odd number, one ray is the axis")


class FloorTruth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where the floor is not flat; places and signs are drawn by the seed, all on the border.

    sills: number of doorsills across the border. sill_slip: standard deviation of what the wheels
    slip on each, m. sill_turn: rad, likewise. sill_pitch: rad, by which a robot on one nods.
    slopes: number of slopes. slope: rad, how steep.
    """

    sills: Count
    sill_slip: NotNegative
    sill_turn: NotNegative
    sill_pitch: NotNegative
    slopes: Count
    slope: NotNegative


class ThingsTruth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Things that no map shows, at places drawn by the seed near the border.

    tables: of which a laser sees four legs. boxes: have been moved there. doors_open: in the map
    a wall. doors_shut: in the map an opening. low_boxes: under the laser's plane. glass: walls of
    the map that a laser looks through. clearance: m from the border to any of the first four;
    narrowest: m, the same for one in four of them. low_clearance: m, for low boxes.
    """

    tables: Count
    boxes: Count
    doors_open: Count
    doors_shut: Count
    low_boxes: Count
    glass: Count
    clearance: NotNegative
    narrowest: NotNegative
    low_clearance: NotNegative


class PeopleTruth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a laser sees of people. leg: m, width of one; 0 for the outline of the shoulders."""

    leg: NotNegative
