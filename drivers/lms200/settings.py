"""Settings of the laser."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Annotated, Literal

import msgspec

from drivers.lms200.measurement import (
    MEASURING_MODES,
    MODE_32_M,
    MODE_REFLECTIVITY,
    TURN,
    UNIT_CM,
    UNIT_MM,
)
from drivers.lms200.telegrams import VARIANTS, Variant
from drivers.mounting import (
    MountSetting,
    UpsideDownSetting,
    check_mounting,
    in_laser_frame,
    in_own_degrees,
)

_FRAME_BYTES = 10  # of a telegram of measured values, besides two per value
_BITS_PER_BYTE = 10
_OWN_DEGREES = (0.0, 180.0)  # where the scanner's own degrees begin and end
_PARTIAL_VALUES = 181
_QUARTER_DEGREE = 25  # hundredths
_FINEST_FIELD_OF_VIEW = 100  # deg, of the only variant with quarters of a degree
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
            " degrees or in partial scans, 0.25 (four turns)",
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
            description="Each mirror turn comes as a scan of its own, of 180 degrees in steps of 1,"
            " offset in turn by the resolution"
        ),
    ] = False
    mean_of: Annotated[
        int,
        msgspec.Meta(ge=1, le=250, description="Scans that the laser averages for each it sends"),
    ] = 1
    sector: Annotated[
        tuple[int, int] | None,
        msgspec.Meta(
            description="Only the beams from .. to .. are sent, whole degrees as those of ignore;"
            " unset: all",
            extra={"unit": "deg"},
        ),
    ] = None
    remission: Annotated[
        bool,
        msgspec.Meta(
            description="Each range comes with what the beam's end reflects, in measuring mode 14"
        ),
    ] = False
    mount: MountSetting = None
    upside_down: UpsideDownSetting = None
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
                "resolution_deg is 1.0 or 0.5, or 0.25 with a field_of_view_deg of 100 or with "
                f"partial_scans, not {self.resolution_deg:g} with {self.field_of_view_deg}"
            )
        check_mounting(self.mount, self.ignore, _OWN_DEGREES)
        if self.measuring_mode not in MEASURING_MODES:
            modes = ", ".join(map(str, MEASURING_MODES))
            raise ValueError(f"measuring_mode is one of {modes}, not {self.measuring_mode}")
        self._check_output()

    def _check_output(self) -> None:
        """Raise ValueError for an output that no laser has."""
        if self.partial_scans and (self.mean_of > 1 or self.sector or self.remission):
            raise ValueError("partial_scans come without mean_of, sector and remission")
        if self.remission and (self.mean_of > 1 or self.variant.mirror_turns > 1):
            raise ValueError("remission comes with a resolution_deg of 1.0 and without mean_of")
        first, last = self.view_deg
        if self.sector and not first <= self.sector[0] < self.sector[1] <= last:
            raise ValueError(
                f"sector is {list(self.sector)}: write [from, to], {first:g} to {last:g} degrees,"
                " from the scanner's right"
            )
        if self.silence <= self.scan_period:
            raise ValueError(
                f"a scan comes every {self.scan_period:.2g} s: silence must be longer than that"
            )

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
        """Field of view and resolution in the laser's units; partial scans have a view of 180."""
        resolution_cdeg = round(self.resolution_deg * 100)
        if self.partial_scans and resolution_cdeg == _QUARTER_DEGREE:
            return Variant(_FINEST_FIELD_OF_VIEW, resolution_cdeg)
        return Variant(self.field_of_view_deg, resolution_cdeg)

    @property
    def view_deg(self) -> tuple[float, float]:
        """The scanner's own degrees at which its view begins and ends."""
        angle = _OWN_DEGREES[1] if self.partial_scans else self.variant.angle_deg
        return (_OWN_DEGREES[1] - angle) / 2, (_OWN_DEGREES[1] + angle) / 2

    @property
    def part(self) -> tuple[int, int] | None:
        """First and last value of ``sector``, 1-based; None for the whole scan."""
        if self.sector is None:
            return None
        first, last = (round((deg - self.view_deg[0]) / self.resolution_deg) for deg in self.sector)
        return first + 1, last + 1

    @property
    def mode_code(self) -> int:
        """Number of the measuring mode that the laser is set to."""
        return MODE_REFLECTIVITY if self.remission else self.measuring_mode

    @property
    def ignored(self) -> tuple[tuple[float, float], ...]:
        """The sectors of ``ignore`` in the laser frame: first and last direction, rad."""
        return in_laser_frame(self.ignore, upside_down=bool(self.upside_down))

    @property
    def seen(self) -> tuple[float, float]:
        """First and last direction of the beams that are sent, rad, laser frame."""
        (ends,) = in_laser_frame(
            (self.sector or self.view_deg,), upside_down=bool(self.upside_down)
        )
        return ends

    def degrees_of(self, sectors: Iterable[tuple[float, float]]) -> list[list[float]]:
        """Return sectors of the laser frame, rad, as ``ignore`` has them, in whole degrees."""
        return in_own_degrees(sectors, _OWN_DEGREES, upside_down=bool(self.upside_down))

    @property
    def scan_period(self) -> float:
        """Time between two scans, s: whole mirror turns, no less than a scan takes on the line.

        Source: SICK telegram listing 8007954/Q501, scans lost at each rate.
        """
        interlaced = self.variant.mirror_turns
        whole = _PARTIAL_VALUES if self.partial_scans else self.variant.count
        first, last = self.part or (1, whole)
        bytes_per_value = 4 if self.remission else 2
        sent = bytes_per_value * (last - first + 1) + _FRAME_BYTES
        turns = math.ceil(sent * _BITS_PER_BYTE / self.baud / TURN)
        if self.partial_scans:  # each is the next of the interlaced turns
            return (turns + (1 - turns) % interlaced) * TURN
        return (turns + -turns % interlaced + (self.mean_of - 1) * interlaced) * TURN

    @property
    def unit_code(self) -> int:
        """Code of the units in the laser's configuration."""
        return _UNIT_CODES[self.units]
