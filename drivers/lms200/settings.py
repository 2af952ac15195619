"""Settings of the laser."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Annotated, Literal

import msgspec

from drivers.lms200.measurement import MEASURING_MODES, MODE_32_M, TURN, UNIT_CM, UNIT_MM
from drivers.lms200.telegrams import VARIANTS, Variant
from drivers.mounting import check_mounting, in_laser_frame, in_own_degrees

_FRAME_BYTES = 10  # of a telegram of measured values, besides two per value
_BITS_PER_BYTE = 10
_OWN_DEGREES = (0.0, 180.0)  # where the scanner's own degrees begin and end
_UNIT_CODES = {"cm": UNIT_CM, "mm": UNIT_MM}


class LaserSettings(
    msgspec.Struct,
    frozen=True,
    kw_only=True,
    forbid_unknown_fields=True,
    tag_field="kind",
    tag="lms200",
):
    """Address, mounting and operating mode of the laser.

    A laser behind the base controller's auxiliary port is not supported: TTY2 and SERAUX carry at
    most 200 bytes a cycle of 100 ms, a scan of 181 values takes 372.
    """

    url: Annotated[
        str,
        msgspec.Meta(
            description="Serial port of the laser: a device, pseudo-terminal or pyserial URL"
        ),
    ] = "/dev/ttyS2"
    baud: Annotated[
        Literal[9600, 19200, 38400, 500000],
        msgspec.Meta(
            description="Rate the laser's line is run at; 500000 needs RS-422",
            extra={"unit": "baud"},
        ),
    ] = 38400
    field_of_view_deg: Annotated[
        Literal[100, 180],
        msgspec.Meta(description="Field of view, centred ahead", extra={"unit": "deg"}),
    ] = 180
    resolution_deg: Annotated[
        float,
        msgspec.Meta(
            description="Angle between beams: 1.0, 0.5 (two interlaced mirror turns) or, of 100"
            " degrees, 0.25 (four turns)",
            extra={"unit": "deg"},
        ),
    ] = 1.0
    measuring_mode: Annotated[
        int,
        msgspec.Meta(
            description="Number in SICK's telegram listing; 5 is up to 32 m and a reflector bit"
        ),
    ] = MODE_32_M
    units: Annotated[
        Literal["mm", "cm"],
        msgspec.Meta(description="Unit of the ranges sent; cm is for ten times the mode's range"),
    ] = "mm"
    partial_scans: Annotated[
        bool,
        msgspec.Meta(
            description="Each mirror turn comes as a scan of its own, in steps of 1 degree"
        ),
    ] = False
    mount: Annotated[
        tuple[float, float, float] | None,
        msgspec.Meta(
            description="Place of the laser in base_link: x, y, theta; unset: the model's",
            extra={"unit": "m, m, rad"},
        ),
    ] = None
    upside_down: Annotated[
        bool | None,
        msgspec.Meta(
            description="The scanner is mounted upside down: its beams run clockwise; unset: as"
            " the model's"
        ),
    ] = None
    ignore: Annotated[
        tuple[tuple[float, float], ...],
        msgspec.Meta(
            description="Sectors [from, to] in which the scanner sees its own robot, in its own"
            " degrees: 0 right, 90 ahead, 180 left of it when it stands upright",
            extra={"unit": "deg"},
        ),
    ] = ()
    silence: Annotated[
        float,
        msgspec.Meta(
            gt=0.0,
            description="Time without a scan after which the laser is looked for again",
            extra={"unit": "s"},
        ),
    ] = 2.0

    def __post_init__(self) -> None:
        if self.variant not in VARIANTS:
            raise ValueError(
                "resolution_deg is 1.0 or 0.5, or 0.25 with a field_of_view_deg of 100, "
                f"not {self.resolution_deg:g} with {self.field_of_view_deg}"
            )
        check_mounting(self.mount, self.ignore, _OWN_DEGREES)
        if self.measuring_mode not in MEASURING_MODES:
            modes = ", ".join(map(str, MEASURING_MODES))
            raise ValueError(f"measuring_mode is one of {modes}, not {self.measuring_mode}")

    def mounted(
        self, *, upside_down: bool, ignore: tuple[tuple[float, float], ...] = ()
    ) -> LaserSettings:
        """Return the settings on a robot model.

        upside_down: whether the model's scanner is, which counts where the settings do not say.
        ignore: sectors in which it sees its own robot; those of the settings are added.
        """
        over = upside_down if self.upside_down is None else self.upside_down
        return msgspec.structs.replace(self, upside_down=over, ignore=ignore + self.ignore)

    @property
    def housing(self) -> tuple[float, float]:
        """Depth and width of the scanner, m (SICK's data sheet)."""
        return 0.156, 0.155

    @property
    def variant(self) -> Variant:
        """Field of view and resolution in the laser's units."""
        return Variant(self.field_of_view_deg, round(self.resolution_deg * 100))

    @property
    def ignored(self) -> tuple[tuple[float, float], ...]:
        """The sectors of ``ignore`` in the laser frame: first and last direction, rad."""
        return in_laser_frame(self.ignore, upside_down=bool(self.upside_down))

    def degrees_of(self, sectors: Iterable[tuple[float, float]]) -> list[list[float]]:
        """Return sectors of the laser frame, rad, as ``ignore`` has them, in whole degrees."""
        return in_own_degrees(sectors, _OWN_DEGREES, upside_down=bool(self.upside_down))

    @property
    def scan_period(self) -> float:
        """Time between two scans, s: whole mirror turns, no less than a scan takes on the line.

        Source: SICK telegram listing 8007954/Q501, scans lost at each rate.
        """
        interlaced = self.variant.mirror_turns
        values = self.field_of_view_deg + 1 if self.partial_scans else self.variant.count
        on_wire = (2 * values + _FRAME_BYTES) * _BITS_PER_BYTE / self.baud
        turns = math.ceil(on_wire / TURN)
        if self.partial_scans:  # each is the next of the interlaced turns
            return (turns + (1 - turns) % interlaced) * TURN
        return (turns + -turns % interlaced) * TURN

    @property
    def unit_code(self) -> int:
        """Code of the units in the laser's configuration."""
        return _UNIT_CODES[self.units]
