"""Builds a map from a log of scans at known poses.

``build_map`` traces every beam through a grid and counts, per cell, the scans that passed through
it (misses) and those that ended in it (hits): Moravec and Elfes' occupancy grid in its counting
form. A cell is occupied if the share of hits is large enough, so people who walked by disappear.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from maps.input_limits import MAX_CELLS
from maps.occupancy_map import FREE, OCCUPIED, UNKNOWN, MapError, OccupancyMap, Surface
from maps.pose import Pose

Scans = Literal["all", "even", "odd"]

_CHOICE = {"all": slice(None), "even": slice(0, None, 2), "odd": slice(1, None, 2)}
_MARGIN = 1.0  # m of unknown cells round all known ones


class PosedScan(Protocol):
    """A laser scan taken at a known pose."""

    @property
    def reference(self) -> Pose:
        """map_from_laser."""

    def beams(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return (n,) ranges, m, and (n,) directions in the laser's frame, rad."""


class PosedLog(Protocol):
    """Scans to build a map of."""

    @property
    def path(self) -> Path:
        """Source of the scans, for messages."""

    @property
    def scans(self) -> Sequence[PosedScan]:
        """The scans, in the order taken."""


@dataclass(frozen=True, slots=True, eq=False)
class MapBuild:
    """A built map and the numbers to print with it."""

    map: OccupancyMap
    scans: int
    """Scans used."""
    beams: int
    """Beams used: those with a return within the range limit."""
    free: int
    occupied: int
    unknown: int
    """Cells of each state."""
    seconds: float
    """Time of the build, s."""

    def summary(self) -> str:
        """Return one line: scans, cells, seconds."""
        width, height = self.map.size
        return (
            f"{self.scans} scans, {self.beams} beams: {width:.1f} x {height:.1f} m, "
            f"{self.free} free, {self.occupied} occupied, {self.unknown} unknown cells "
            f"in {self.seconds:.1f} s"
        )


def build_map(
    log: PosedLog,
    resolution: float = 0.05,
    *,
    scans: Scans = "all",
    max_range: float = 20.0,
    occupied_share: float = 0.25,
    min_sightings: int = 2,
    progress: Callable[[float], None] | None = None,
) -> MapBuild:
    """Build an occupancy map of a log's scans at their reference poses.

    resolution: cell side, m. scans: all, or every second one starting with the first (even) or
    the second (odd), so that a map can be tested on scans it was not built from. max_range, m:
    longer beams are left out. occupied_share: least share of hits, of hits and misses, of an
    occupied cell. min_sightings: cells with fewer hits and misses stay unknown. progress: called
    with the number of scans done.

    Raises MapError if there is no scan to use, no free floor, or the grid would be too large.
    """
    started = time.perf_counter()
    if not (math.isfinite(resolution) and resolution > 0.0):
        raise MapError(f"resolution {resolution:g} is not a positive number of metres")
    chosen = log.scans[_CHOICE[scans]]
    if not chosen:
        raise MapError(f"{log.path}: no {scans} scans in the log, a map needs some")
    beams = [_beams(scan, max_range) for scan in chosen]
    origin, shape = _extent(chosen, beams, resolution)
    if shape[0] * shape[1] > MAX_CELLS:
        width, height = shape[1] * resolution, shape[0] * resolution
        raise MapError(
            f"{log.path}: the scans span {width:.0f} x {height:.0f} m, too much for cells of "
            f"{resolution:g} m: check the poses, or take a coarser resolution"
        )
    hits = np.zeros(shape, dtype=np.int32)
    misses = np.zeros(shape, dtype=np.int32)
    for number, (scan, (ranges, angles)) in enumerate(zip(chosen, beams, strict=True), start=1):
        _count(hits, misses, (scan.reference, origin, resolution), ranges, angles)
        if progress is not None:
            progress(number)
    cells, origin = _crop(
        _classify(hits, misses, occupied_share, min_sightings), resolution, origin
    )
    if not (cells == FREE).any():
        raise MapError(
            f"{log.path}: {len(chosen)} scans show no free floor twice: a map needs more of them"
        )
    return MapBuild(
        map=OccupancyMap(cells, resolution, origin, Surface.CENTRE),
        scans=len(chosen),
        beams=sum(len(ranges) for ranges, _ in beams),
        free=int(np.count_nonzero(cells == FREE)),
        occupied=int(np.count_nonzero(cells == OCCUPIED)),
        unknown=int(np.count_nonzero(cells == UNKNOWN)),
        seconds=time.perf_counter() - started,
    )


def _beams(scan: PosedScan, max_range: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return ranges (n,), m, and directions (n,), rad, map frame, of the beams to use."""
    ranges, angles = scan.beams()
    used = ranges < max_range
    return ranges[used], scan.reference.theta + angles[used]


def _extent(
    scans: Sequence[PosedScan],
    beams: Sequence[tuple[NDArray[np.float64], NDArray[np.float64]]],
    resolution: float,
) -> tuple[Pose, tuple[int, int]]:
    """Return the origin, a multiple of the cell, and (rows, cols) of a grid for all scans."""
    ends = np.concatenate(
        [
            np.array([scan.reference[:2]])
            + np.concatenate([[0.0], ranges])[:, None]
            * np.column_stack([np.cos([0.0, *angles]), np.sin([0.0, *angles])])
            for scan, (ranges, angles) in zip(scans, beams, strict=True)
        ]
    )
    low = np.floor((ends.min(axis=0) - _MARGIN) / resolution)
    high = np.ceil((ends.max(axis=0) + _MARGIN) / resolution)
    cols, rows = (high - low).astype(int)
    x, y = (round(float(value) * resolution, 9) for value in low)
    return Pose(x, y, 0.0), (int(rows), int(cols))


def _count(
    hits: NDArray[np.int32],
    misses: NDArray[np.int32],
    frame: tuple[Pose, Pose, float],
    ranges: NDArray[np.float64],
    angles: NDArray[np.float64],
) -> None:
    """Add one scan: a hit to each cell in which a beam ends, a miss to each other cell crossed.

    frame: map_from_laser, the grid's origin, m, the cell's side, m.
    """
    laser, origin, resolution = frame
    width = hits.shape[1]
    unit = np.column_stack([np.cos(angles), np.sin(angles)]) / resolution
    start = (np.array(laser[:2]) - origin[:2]) / resolution

    # Samples every half cell along each beam, up to one cell before its end: a wall at a grazing
    # angle must not be cleared by its own beams.
    steps = np.arange(0.0, ranges.max(initial=0.0), resolution / 2)
    reach = np.searchsorted(steps, ranges - resolution)
    beam = np.repeat(np.arange(len(ranges)), reach)
    along = steps[np.arange(len(beam)) - np.repeat(np.cumsum(reach) - reach, reach)]
    crossed = np.floor(start + along[:, None] * unit[beam]).astype(np.int64)
    ended = np.floor(start + ranges[:, None] * unit).astype(np.int64)

    hit_cells = np.unique(ended[:, 1] * width + ended[:, 0])
    seen = np.zeros(hits.size, dtype=np.bool_)
    seen[crossed[:, 1] * width + crossed[:, 0]] = True
    seen[hit_cells] = False
    hits.ravel()[hit_cells] += 1
    misses += seen.reshape(misses.shape)


def _classify(
    hits: NDArray[np.int32], misses: NDArray[np.int32], occupied_share: float, min_sightings: int
) -> NDArray[np.uint8]:
    """Return each cell's state by its counts."""
    sightings = hits + misses
    cells = np.where(hits > occupied_share * sightings, OCCUPIED, FREE).astype(np.uint8)
    cells[sightings < min_sightings] = UNKNOWN
    return cells


def _crop(
    cells: NDArray[np.uint8], resolution: float, origin: Pose
) -> tuple[NDArray[np.uint8], Pose]:
    """Return the map without unknown cells beyond a margin: stray beams enlarge the grid."""
    margin = round(_MARGIN / resolution)
    rows, cols = np.nonzero(cells != UNKNOWN)
    if len(rows) == 0:
        return cells, origin
    row0, col0 = max(rows.min() - margin, 0), max(cols.min() - margin, 0)
    cropped = cells[row0 : rows.max() + margin + 1, col0 : cols.max() + margin + 1]
    x = round(origin.x + float(col0) * resolution, 9)
    y = round(origin.y + float(row0) * resolution, 9)
    return np.ascontiguousarray(cropped), Pose(x, y, 0.0)
