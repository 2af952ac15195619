"""Cost of the localizer: an update by particles and beams; memory and times on a large map."""

from __future__ import annotations

import itertools
import time
import tracemalloc
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from localization.cluster import best_cluster
from localization.filter import ParticleFilter
from localization.kld import SampleLimits
from localization.likelihood_field import LikelihoodField
from localization.localizer import INDEPENDENT_BEAMS, Localizer
from localization.settings import LocalizationSettings, MotionNoise
from maps.map_folder import load_map_folder
from maps.occupancy_map import FREE, OCCUPIED, OccupancyMap
from maps.pose import Pose
from tools.simulation.raycast import RayCaster

PARTICLES = (500, 2000, 5000)
BEAMS = (60, 180)
UPDATES = 120
PASSES = 3
STEP = 0.3  # m between two scans
SEED = 1
LARGE_MAP = 4800
"""Cells a side of the map whose memory is measured: 240 m, 23 million cells."""
CELL = 0.05  # m; side of one of its cells
WALL = 3  # cells; thickness of its walls

Scans = list[tuple[Pose, NDArray[np.float64]]]
"""Poses (map_from_base) and end points (n, 2), base_link, m."""


@dataclass(frozen=True, slots=True)
class UpdateCost:
    """Median times of one scan's update on one thread."""

    particles: int
    beams: int
    filter_ms: float
    """Motion, weights, estimate, KLD bins, resampling: as other packages' figures count."""
    whole_ms: float
    """All of ``Localizer.update``: with refinement and scan check."""

    @property
    def products_per_s(self) -> float:
        """Particle-beam products of the filter, 1/s."""
        return 1e3 * self.particles * self.beams / self.filter_ms


@dataclass(frozen=True, slots=True)
class LargeMapCost:
    """Cost of a localizer on a large map, beside the map itself."""

    kept: float
    """Memory kept, tracking, bytes a cell of the map."""
    peak: float
    """Most memory in use since the start, likewise."""
    start_s: float
    """Time of the start, s of thread CPU time."""
    search_ms: float
    """Longest time of a scan in a search of the whole map, ms of thread CPU time."""


def update_costs(folder_path: Path) -> Iterator[UpdateCost]:
    """Time updates along a map folder's border, for every number of particles and beams.

    Raises ValueError if the folder has no border.
    """
    folder = load_map_folder(folder_path)
    if folder.border is None:
        raise ValueError(f"{folder_path} has no border to drive along")
    scans = scans_along(folder.map, folder.border.polyline(STEP)[:UPDATES])
    for beams in BEAMS:
        for particles in PARTICLES:
            settings = LocalizationSettings(
                beams=beams, min_particles=particles, max_particles=particles
            )
            yield UpdateCost(
                particles,
                beams,
                1e3 * _best_median(_filter_update, settings, folder.map, scans),
                1e3 * _best_median(_whole_update, settings, folder.map, scans),
            )


def scans_along(occupancy: OccupancyMap, path: NDArray[np.float64]) -> Scans:
    """Simulate scans of 181 beams over the half circle ahead, at the points of a path (n, 2), m.

    Each heading is that to the next point, so there are n - 1 scans. Range noise: sigma 0.01 m.
    """
    caster, rng = RayCaster(occupancy), np.random.default_rng(SEED)
    bearings = np.radians(np.arange(-90.0, 91.0))
    scans: Scans = []
    for (x, y), (next_x, next_y) in itertools.pairwise(path):
        pose = Pose(float(x), float(y), float(np.arctan2(next_y - y, next_x - x)))
        ranges = caster.cast(pose.x, pose.y, pose.theta + bearings, 32.0)
        ranges += rng.normal(0.0, 0.01, ranges.size)
        hit = np.isfinite(ranges)
        points = np.column_stack((np.cos(bearings), np.sin(bearings))) * ranges[:, np.newaxis]
        scans.append((pose, points[hit]))
    return scans


def _filter_update(
    settings: LocalizationSettings, occupancy: OccupancyMap, scans: Scans
) -> Callable[[int], object]:
    rng = np.random.default_rng(SEED)
    field = LikelihoodField(occupancy, settings.beams)
    particles = ParticleFilter(settings.motion.over(MotionNoise()), field, rng)
    cloud = rng.standard_normal((settings.min_particles, 3)) * (0.1, 0.1, 0.05)
    limits = SampleLimits(settings.min_particles, settings.max_particles)
    particles.restart(np.array(scans[0][0]) + cloud)

    def update(number: int) -> None:
        pose, points = scans[number]
        particles.predict(scans[max(number - 1, 0)][0].between(pose))
        particles.weigh(points, INDEPENDENT_BEAMS)
        best_cluster(particles.particles, particles.weights)
        particles.resample(limits)

    return update


def _whole_update(
    settings: LocalizationSettings, occupancy: OccupancyMap, scans: Scans
) -> Callable[[int], object]:
    localizer = Localizer(settings, occupancy, np.random.default_rng(SEED))
    localizer.start_at(scans[0][0], 0.1, 0.05)
    return lambda number: localizer.update(float(number), *scans[number])


def _best_median(
    start: Callable[[LocalizationSettings, OccupancyMap, Scans], Callable[[int], object]],
    settings: LocalizationSettings,
    occupancy: OccupancyMap,
    scans: Scans,
) -> float:
    """Return the median time of an update over all scans, s of thread CPU time (one thread).

    The best of ``PASSES``: other load on the machine can only slow a pass down.
    """
    return min(_median(start(settings, occupancy, scans), scans) for _ in range(PASSES))


def _median(update: Callable[[int], object], scans: Scans) -> float:
    return float(np.median(_times(update, len(scans))))


def _times(update: Callable[[int], object], count: int) -> list[float]:
    """Return the times of ``count`` updates, s of thread CPU time."""
    times = []
    for number in range(count):
        started = time.thread_time()
        update(number)
        times.append(time.thread_time() - started)
    return times


def large_map_cost(side: int = LARGE_MAP) -> LargeMapCost:
    """Return the cost of a localizer on a square map of so many cells a side."""
    walls = _walls(side)
    occupancy = _rooms(side, walls)
    low, high = walls[len(walls) // 2 : len(walls) // 2 + 2] * CELL
    low += WALL * CELL  # faces of the room's walls
    scans = [_seen(low, high, 0.5 * (low + high) + STEP * (n % 3), low + 2.0) for n in range(30)]
    tracemalloc.start()
    try:
        started = time.thread_time()
        localizer = Localizer(LocalizationSettings(), occupancy, np.random.default_rng(SEED))
        start_s = time.thread_time() - started
        localizer.start_at(scans[0][0], 0.1, 0.05)
        localizer.update(0.0, *scans[0])
        kept, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    localizer.start_anywhere()
    times = _times(lambda number: localizer.update(float(number), *scans[number]), len(scans))
    return LargeMapCost(kept / side**2, peak / side**2, start_s, 1e3 * max(times))


def _walls(side: int) -> NDArray[np.intp]:
    """Return (n,) first rows, and columns, of walls at distances of 6 to 12 m."""
    widths = np.random.default_rng(SEED).integers(round(6.0 / CELL), round(12.0 / CELL), side)
    starts = np.concatenate(([0], np.cumsum(widths)))
    return np.asarray(starts[starts < side], dtype=np.intp)


def _rooms(side: int, walls: NDArray[np.intp]) -> OccupancyMap:
    """Return a square map of rooms between walls that begin at the same rows and columns."""
    cells = np.full((side, side), FREE, dtype=np.uint8)
    for start in walls:
        cells[start : start + WALL] = cells[:, start : start + WALL] = OCCUPIED
    return OccupancyMap(cells, CELL, Pose(0.0, 0.0, 0.0))


def _seen(low: float, high: float, x: float, y: float) -> tuple[Pose, NDArray[np.float64]]:
    """Return a pose at (x, y) in a square room, m, and the end points (181, 2) of its scan."""
    directions = np.column_stack([f(np.radians(np.arange(-90.0, 91.0))) for f in (np.cos, np.sin)])
    with np.errstate(divide="ignore"):
        to_walls = (np.where(directions > 0.0, high, low) - np.array((x, y))) / directions
    return Pose(x, y, 0.0), directions * np.abs(to_walls).min(axis=1)[:, np.newaxis]
