"""Settings of a SOPAS scanner."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated

import msgspec

from drivers.lms1xx.framing import ETHERNET
from drivers.lms1xx.telegrams import PER_DEGREE, PER_HERTZ, OutputRange, Scanning
from drivers.mounting import (
    MountSetting,
    Sectors,
    UpsideDownSetting,
    check_mounting,
    in_laser_frame,
    in_own_degrees,
)

_AHEAD_DEG = 90.0  # the scanner's own degrees straight ahead
_WIDEST_DEG = 270.0
_REQUEST_PERIOD = 0.05  # s
_OWN_DEGREES = (_AHEAD_DEG - _WIDEST_DEG / 2, _AHEAD_DEG + _WIDEST_DEG / 2)
"""Where the scanner's own degrees begin and end."""
RESOLUTIONS = (0.1667, 0.25, 0.3333, 0.5, 0.6667, 1.0)
"""Degrees: 0.25 and 0.5 of an LMS 1xx, 0.3333 and 1 of a TiM5xx, all but 0.3333 of an LMS 5xx."""
FREQUENCIES = (15.0, 25.0, 35.0, 50.0, 75.0, 100.0)
"""Hertz: 25 and 50 of an LMS 1xx, 15 of a TiM5xx, all but 15 of an LMS 5xx."""


class LaserSettings(
    msgspec.Struct,
    frozen=True,
    kw_only=True,
    forbid_unknown_fields=True,
    tag_field="kind",
    tag="lms1xx",
):
    """Address, mounting and operating mode of the scanner.

    Which frequency goes with which resolution the scanner knows: a pair that it refuses is a
    trouble of the session, and the scanner goes on as it was.
    """

    url: Annotated[
        str,
        msgspec.Meta(
            description="Address of the scanner, socket://host:port; the port is 2111 or 2112"
        ),
    ] = "socket://192.168.0.1:2111"
    frequency: Annotated[
        float,
        msgspec.Meta(
            description="Scans a second: 25 or 50, others of other models", extra={"unit": "Hz"}
        ),
    ] = 50.0
    resolution_deg: Annotated[
        float,
        msgspec.Meta(
            description="Angle between beams: 0.5 or, at 25 Hz, 0.25; others of other models",
            extra={"unit": "deg"},
        ),
    ] = 0.5
    field_of_view_deg: Annotated[
        float,
        msgspec.Meta(
            gt=0.0,
            le=_WIDEST_DEG,
            description="Field of view, centred ahead",
            extra={"unit": "deg"},
        ),
    ] = _WIDEST_DEG
    by_request: Annotated[
        bool,
        msgspec.Meta(description="Ask for each scan, 20 a second at most, for a slow network"),
    ] = False
    mount: MountSetting = None
    upside_down: UpsideDownSetting = None
    ignore: Annotated[
        tuple[tuple[float, float], ...],
        msgspec.Meta(
            description="Sectors [from, to] in which the scanner sees its own robot, in its own"
            " degrees: 0 right, 90 ahead, 180 left of it when it stands upright, -45 to 225",
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
        if self.resolution_deg not in RESOLUTIONS:
            known = ", ".join(f"{each:g}" for each in RESOLUTIONS)
            raise ValueError(f"resolution_deg is one of {known}, not {self.resolution_deg:g}")
        if self.frequency not in FREQUENCIES:
            known = ", ".join(f"{each:g}" for each in FREQUENCIES)
            raise ValueError(f"frequency is one of {known}, not {self.frequency:g}")
        check_mounting(self.mount, self.ignore, _OWN_DEGREES)

    def mounted(self, *, upside_down: bool, ignore: Sectors = ()) -> LaserSettings:
        """Return the settings on a robot model.

        upside_down: whether the model's scanner is, which counts where the settings do not say.
        ignore: sectors in which it sees its own robot; those of the settings are added.
        """
        over = upside_down if self.upside_down is None else self.upside_down
        return msgspec.structs.replace(self, upside_down=over, ignore=ignore + self.ignore)

    @property
    def baud(self) -> int:
        """Rate of its line, bit/s: its network's."""
        return ETHERNET

    @property
    def housing(self) -> tuple[float, float]:
        """Depth and width of the scanner, m (SICK's data sheet of the LMS 111)."""
        return 0.105, 0.102

    @property
    def scan_period(self) -> float:
        """Time between two scans, s; by request they are asked for at the agent's ticks."""
        turn_time = 1.0 / self.frequency
        return max(turn_time, _REQUEST_PERIOD) if self.by_request else turn_time

    @property
    def ignored(self) -> Sectors:
        """The sectors of ``ignore`` in the laser frame: first and last direction, rad."""
        return in_laser_frame(self.ignore, upside_down=bool(self.upside_down))

    def degrees_of(self, sectors: Iterable[tuple[float, float]]) -> list[list[float]]:
        """Return sectors of the laser frame, rad, as ``ignore`` has them, in whole degrees."""
        return in_own_degrees(sectors, _OWN_DEGREES, upside_down=bool(self.upside_down))

    def scanning(self, present: Scanning) -> Scanning:
        """Return how the scanner shall measure; the sector stays as it is."""
        frequency, resolution = round(self.frequency * PER_HERTZ), self._resolution
        return Scanning(frequency, resolution, present.first, present.last)

    @property
    def output_range(self) -> OutputRange:
        """The part of its sector that shall be sent."""
        half = self.field_of_view_deg / 2
        first, last = (round((_AHEAD_DEG + end) * PER_DEGREE) for end in (-half, half))
        return OutputRange(self._resolution, first, last)

    @property
    def _resolution(self) -> int:
        return round(self.resolution_deg * PER_DEGREE)
