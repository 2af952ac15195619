"""A scanner on its robot: where it sits, whether it is turned over, what it shall not look at."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import Annotated, Protocol

import msgspec
import numpy as np
from numpy.typing import NDArray

from drivers.scan import Scan, Special

Sectors = tuple[tuple[float, float], ...]
"""First and last direction of each, rad, laser frame; or in the scanner's own degrees."""

MountSetting = Annotated[
    tuple[float, float, float] | None,
    msgspec.Meta(
        description="Place of the laser in base_link: x, y, theta; unset: the model's",
        extra={"unit": "m, m, rad"},
    ),
]
UpsideDownSetting = Annotated[
    bool | None,
    msgspec.Meta(
        description="The scanner is mounted upside down: its beams run clockwise; unset: as"
        " the model's"
    ),
]

_AHEAD_DEG = 90.0  # the scanner's own degrees straight ahead
_FARTHEST_MOUNT = 1.0  # m from the axle, either way
_ROUNDING = 1e-9  # rad; a sector's ends belong to it


class Mounting(Protocol):
    """What the settings of any scanner say of its mounting."""

    @property
    def upside_down(self) -> bool | None:
        """Whether the scanner is turned over; None: not said, it is not."""

    @property
    def ignored(self) -> Sectors:
        """The sectors not looked into, laser frame, rad."""


def as_mounted(scan: Scan, mounting: Mounting) -> Scan:
    """Return a scan in the laser frame, in which left is left also for a scanner upside down.

    Beams in a sector of ``laser.ignore`` have no range.
    """
    if mounting.upside_down:
        scan = _turned_over(scan)
    sectors = mounting.ignored
    if not sectors:
        return scan
    angles = scan.angles
    ignored = np.zeros(angles.shape, dtype=np.bool_)
    for first, last in sectors:
        ignored |= (angles >= first - _ROUNDING) & (angles <= last + _ROUNDING)
    return without(scan, ignored, Special.IGNORED)


def without(scan: Scan, beams: NDArray[np.bool_], why: Special) -> Scan:
    """Return a scan in which some beams (n,) have no range."""
    return replace(
        scan,
        ranges=np.where(beams, np.inf, scan.ranges),
        specials=np.where(beams, np.uint8(why), scan.specials),
    )


def in_laser_frame(sectors: Sectors, *, upside_down: bool) -> Sectors:
    """Return sectors of the scanner's own degrees (0 right, 90 ahead, 180 left) in rad."""
    upright = [
        (math.radians(first - _AHEAD_DEG), math.radians(last - _AHEAD_DEG))
        for first, last in sectors
    ]
    return tuple((-b, -a) if upside_down else (a, b) for a, b in upright)


def in_own_degrees(
    sectors: Iterable[tuple[float, float]], view: tuple[float, float], *, upside_down: bool
) -> list[list[float]]:
    """Return sectors, rad, in the scanner's own degrees, whole ones within its view."""
    turned = [(-b, -a) if upside_down else (a, b) for a, b in sectors]
    return sorted(
        [
            max(math.floor(math.degrees(first) + _AHEAD_DEG), round(view[0])),
            min(math.ceil(math.degrees(last) + _AHEAD_DEG), round(view[1])),
        ]
        for first, last in turned
    )


def check_mounting(
    mount: tuple[float, float, float] | None, ignore: Sectors, view: tuple[float, float]
) -> None:
    """Raise ValueError for a mount that no robot has, likely in other units, or a bad sector.

    view: where the scanner's own degrees begin and end.
    """
    if mount is not None:
        x, y, theta = mount
        if max(abs(x), abs(y)) > _FARTHEST_MOUNT:
            raise ValueError(
                f"mount is {x:g}, {y:g} m from the axle, no robot is as large: millimetres? write m"
            )
        if abs(theta) > math.pi:
            raise ValueError(f"mount has theta {theta:g}, beyond half a turn: degrees? write rad")
    for first, last in ignore:
        if not view[0] <= first < last <= view[1]:
            raise ValueError(
                f"ignore has [{first:g}, {last:g}]: write [from, to], {view[0]:g} to {view[1]:g}"
                " degrees, from the scanner's right"
            )


def _turned_over(scan: Scan) -> Scan:
    return replace(
        scan,
        angle_min=-(scan.angle_min + scan.angle_increment * (scan.ranges.size - 1)),
        ranges=scan.ranges[::-1],
        specials=scan.specials[::-1],
        flags=scan.flags[::-1],
        reflectors=None if scan.reflectors is None else scan.reflectors[::-1],
        clockwise=not scan.clockwise,
        remission=None if scan.remission is None else scan.remission[::-1],
    )
