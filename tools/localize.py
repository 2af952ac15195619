"""Localization alone on a log or recording, judged against the reference poses it carries."""

from __future__ import annotations

import csv
import dataclasses
import math
import resource
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from localization.estimate import Estimate
from localization.health import Health
from localization.localizer import Localizer
from localization.settings import LocalizationSettings
from maps.map_folder import MapFolder
from maps.occupancy_map import OccupancyMap
from maps.pose import Pose, wrap_angle
from tools.carmen import CarmenLog, LogError

ASTRAY_M = 1.0
"""An estimate farther than this from the reference counts as lost, whatever the filter believes."""

Progress = Callable[[int], None]
"""Called with the scans done."""


@dataclass(frozen=True, slots=True, eq=False)
class LocalizeStep:
    """One scan to localize with."""

    t: float
    odometry: Pose
    """odom_from_base at the scan."""
    points: NDArray[np.float64]
    """(n, 2) end points of the beams that returned, m, base_link."""
    reference: Pose | None
    """True map_from_base, if known."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LocalizeOptions:
    """How to run the localizer."""

    particles: int | None = None
    """A fixed number, or None for KLD sampling."""
    beams: int | None = None
    """Beams per scan; None: as in the settings."""
    seed: int = 0
    start: Pose | None = None
    """map_from_base at the first scan; None: its reference."""
    start_sigma_xy: float = 0.1
    """Standard deviation of the first particles, m; rad for theta."""
    start_sigma_theta: float = 0.05
    start_noise: bool = False
    """Whether the start itself is off by a sample of these deviations."""
    anywhere: bool = False
    """Start with no idea of the pose (global localization)."""
    first_scan: int = 0
    """Scans before this one are left out."""
    settings: LocalizationSettings = dataclasses.field(default_factory=LocalizationSettings)


@dataclass(frozen=True, slots=True)
class LocalizeRow:
    """One scan's outcome; errors are None without a reference."""

    t: float
    x: float
    y: float
    theta: float
    reference_x: float | None
    reference_y: float | None
    reference_theta: float | None
    position_error_m: float | None
    heading_error_deg: float | None
    health: str
    likelihood: float
    sigma_xy_m: float
    sigma_theta_deg: float
    particles: int
    effective_sample_size: float
    update_ms: float


@dataclass(frozen=True, slots=True)
class LocalizeResult:
    """All rows and the summary that ``--json`` prints."""

    rows: list[LocalizeRow]
    summary: dict[str, object]

    def write_csv(self, path: Path) -> None:
        """Write one line per scan under a heading."""
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(LocalizeRow.__dataclass_fields__)
            for row in self.rows:
                writer.writerow(
                    "" if value is None else value for value in dataclasses.astuple(row)
                )

    def write_json(self, path: Path) -> None:
        """Write the summary."""
        path.write_bytes(msgspec.json.format(msgspec.json.encode(self.summary), indent=2) + b"\n")


def localize(
    log: CarmenLog,
    folder: MapFolder,
    options: LocalizeOptions,
    progress: Progress = lambda _: None,
) -> LocalizeResult:
    """Localize on a CARMEN log against a map; the log's laser is taken as the base.

    Raises LogError if ``first_scan`` leaves no scan.
    """
    steps = [
        LocalizeStep(scan.t, scan.odometry, scan.points(), scan.reference) for scan in log.scans
    ]
    return localize_steps(str(log.path), steps, folder, options, progress)


def localize_steps(
    name: str,
    steps: Sequence[LocalizeStep],
    folder: MapFolder,
    options: LocalizeOptions,
    progress: Progress = lambda _: None,
) -> LocalizeResult:
    """Localize on any sequence of scans; ``name`` says where they are from.

    Raises LogError if there is no scan, or no start for it.
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
        rows.append(_row(step, estimate, (time.perf_counter() - began) * 1e3))
        progress(done)
    return LocalizeResult(rows, _summary(name, folder.name, options.seed, rows))


def _started_localizer(
    name: str, first: LocalizeStep, occupancy: OccupancyMap, options: LocalizeOptions
) -> Localizer:
    rng = np.random.default_rng(options.seed)
    localizer = Localizer(_effective_settings(options), occupancy, rng)
    if options.anywhere:
        localizer.start_anywhere()
        return localizer
    start = options.start or first.reference
    if start is None:
        raise LogError(f"{name}: its first scan has no reference pose: give a start pose")
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
    samples = msgspec.structs.replace(
        settings.samples, fixed=options.particles or settings.samples.fixed
    )
    sensor = msgspec.structs.replace(settings.sensor, beams=options.beams or settings.sensor.beams)
    return msgspec.structs.replace(settings, samples=samples, sensor=sensor)


def _row(step: LocalizeStep, estimate: Estimate, update_ms: float) -> LocalizeRow:
    pose, reference, variance = estimate.pose, step.reference, np.diag(estimate.covariance)
    position = heading = None
    if reference is not None:
        position = math.hypot(pose.x - reference.x, pose.y - reference.y)
        heading = abs(math.degrees(wrap_angle(pose.theta - reference.theta)))
    return LocalizeRow(
        t=step.t,
        x=pose.x,
        y=pose.y,
        theta=pose.theta,
        reference_x=None if reference is None else reference.x,
        reference_y=None if reference is None else reference.y,
        reference_theta=None if reference is None else reference.theta,
        position_error_m=position,
        heading_error_deg=heading,
        health=str(estimate.health),
        likelihood=estimate.likelihood,
        sigma_xy_m=math.sqrt(float(variance[0] + variance[1])),
        sigma_theta_deg=math.degrees(math.sqrt(float(variance[2]))),
        particles=estimate.particle_count,
        effective_sample_size=estimate.effective_sample_size,
        update_ms=update_ms,
    )


def _summary(name: str, map_name: str, seed: int, rows: Sequence[LocalizeRow]) -> dict[str, object]:
    """Return the ``--json`` object; statistics without a reference are null."""
    return {
        "log": name,
        "map": map_name,
        "seed": seed,
        "scans": len(rows),
        "lost_share": sum(map(_is_lost, rows)) / len(rows),
        "position_m": _error_statistics(row.position_error_m for row in rows),
        "heading_deg": _error_statistics(row.heading_error_deg for row in rows),
        "update_ms": {
            "median": float(np.median([row.update_ms for row in rows])),
            "p95": float(np.percentile([row.update_ms for row in rows], 95)),
        },
        "particles": {"median": float(np.median([row.particles for row in rows]))},
        "peak_memory_mb": _peak_memory_mb(),
    }


def _is_lost(row: LocalizeRow) -> bool:
    """Tell whether the localizer says it is lost, or is astray without knowing."""
    astray = row.position_error_m is not None and row.position_error_m > ASTRAY_M
    return astray or row.health == Health.LOST


def _error_statistics(errors: Iterable[float | None]) -> dict[str, float | None]:
    known = np.array([error for error in errors if error is not None])
    if known.size == 0:
        return dict.fromkeys(("median", "mean", "rmse", "p95", "max"))
    return {
        "median": float(np.median(known)),
        "mean": float(known.mean()),
        "rmse": float(np.sqrt(np.mean(known**2))),
        "p95": float(np.percentile(known, 95)),
        "max": float(known.max()),
    }


def _peak_memory_mb() -> float:
    """Return the process's largest resident size so far."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1024.0**2 if sys.platform == "darwin" else 1024.0)
