"""Runs localization alone on a log or recording and compares it with the reference poses."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np

from localization.localizer import Localizer
from localization.settings import LocalizationSettings
from maps.map_folder import MapFolder
from maps.occupancy_map import OccupancyMap
from maps.pose import Pose, wrap_angle
from tools.localize.localize_result import LocalizeResult, LocalizeRow
from tools.logs.carmen import CarmenLog, LogError
from tools.logs.log_step import LogStep
from tools.mapping.map_build import Scans, build_map

Progress = Callable[[float], None]
"""Called with the number of scans or runs done."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LocalizeOptions:
    """Options of a run of the localizer."""

    particles: int | None = None
    """Fixed number of particles; None: KLD sampling."""
    beams: int | None = None
    """Beams per scan; None: as in the settings."""
    seed: int = 0
    start: Pose | None = None
    """map_from_base at the first scan; None: the scan's reference."""
    start_sigma_xy: float = 0.1
    """Standard deviation of the initial particles in x and y, m."""
    start_sigma_theta: float = 0.05
    """Standard deviation of the initial particles in theta, rad."""
    start_noise: bool = False
    """Whether to add a sample of these deviations to the start pose."""
    anywhere: bool = False
    """Start without a pose (global localization)."""
    first_scan: int = 0
    """Index of the first scan used."""
    settings: LocalizationSettings = dataclasses.field(default_factory=LocalizationSettings)


def log_steps(log: CarmenLog) -> list[LogStep]:
    """Return a CARMEN log's scans; the laser frame is taken as base_link."""
    return [
        LogStep(scan.t, scan.odometry, scan.points(), scan.reference if log.referenced else None)
        for scan in log.scans
    ]


def map_of_log(
    log: CarmenLog, resolution: float, scans: Scans, progress: Progress | None = None
) -> MapFolder:
    """Return a map of a log's scans at their reference poses, without border and files.

    scans: all, or every second. Raises MapError if no map can be built, LogError if the log has no
    reference poses.
    """
    if not log.referenced:
        raise LogError(
            f"{log.path}: no reference poses, only raw odometry: "
            "make a map by `patrol map build --from odometry` and give it by --map"
        )
    built = build_map(log, resolution, scans=scans, progress=progress)
    return MapFolder(f"{log.path.name} ({scans} scans)", built.map, None, {})


def localize_steps(
    name: str,
    steps: Sequence[LogStep],
    folder: MapFolder,
    options: LocalizeOptions,
    progress: Progress = lambda _: None,
) -> LocalizeResult:
    """Localize on a sequence of scans; name: their source, for messages.

    Raises LogError if there is no scan, or neither a start pose nor a reference for it.
    """
    steps = steps[options.first_scan :]
    if not steps:
        raise LogError(
            f"{name}: no scan from scan {options.first_scan} on: start with an earlier one"
        )
    localizer = _started_localizer(name, steps[0], folder.map, options)
    rows = []
    for done, step in enumerate(steps, start=1):
        began = time.perf_counter()
        estimate = localizer.update(step.t, step.odometry, step.points)
        update_ms = (time.perf_counter() - began) * 1e3
        rows.append(LocalizeRow.of(estimate, step.reference, update_ms))
        progress(done)
    return LocalizeResult(name, folder.name, options.seed, rows)


def _started_localizer(
    name: str, first: LogStep, occupancy: OccupancyMap, options: LocalizeOptions
) -> Localizer:
    rng = np.random.default_rng(options.seed)
    localizer = Localizer(_effective_settings(options), occupancy, rng)
    if options.anywhere:
        localizer.start_anywhere()
        return localizer
    start = options.start or first.reference
    if start is None:
        raise LogError(f"{name}: its first scan has no reference pose: start with --global")
    if options.start_noise:
        off = rng.standard_normal(3)
        start = Pose(
            start.x + options.start_sigma_xy * float(off[0]),
            start.y + options.start_sigma_xy * float(off[1]),
            wrap_angle(start.theta + options.start_sigma_theta * float(off[2])),
        )
    localizer.start_at(start, options.start_sigma_xy, options.start_sigma_theta)
    return localizer


def _effective_settings(options: LocalizeOptions) -> LocalizationSettings:
    settings = options.settings
    return msgspec.structs.replace(
        settings,
        particles=options.particles or settings.particles,
        beams=options.beams or settings.beams,
    )
