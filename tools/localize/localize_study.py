"""Studies of the localization on real logs: accuracy over seeds, with or without hold-out.

Every study builds its maps from the logs' reference poses; every run is one of
``tools.localize.localize`` on a sequence of scans with its own seed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from localization.health import Health
from localization.settings import LocalizationSettings
from maps.map_folder import MapFolder
from tools.localize.localize import LocalizeOptions, Progress, localize_steps, log_steps, map_of_log
from tools.localize.localize_result import LocalizeResult
from tools.localize.occlusion import Occlusion
from tools.logs.carmen import LogError
from tools.logs.laser_log import read_laser_log
from tools.logs.log_step import LogStep

RESOLUTION = 0.05
"""Cell side of the maps built, m."""

Table = list[dict[str, object]]
"""Rows of a table: column name to value."""


@dataclass(frozen=True, slots=True, eq=False)
class StudyLog:
    """A log to localize on, with its map and the map of every second scan."""

    name: str
    steps: list[LogStep]
    """From the first usable scan on."""
    map: MapFolder
    """Map of all scans, or of every so many."""
    even_map: MapFolder
    """Map of the scans 0, 2, 4..."""
    odd_steps: list[LogStep]
    """The scans that ``even_map`` is not built from."""


def read_study_log(
    path: Path,
    first_scan: int = 0,
    max_range: float | None = None,
    *,
    map_every: int = 1,
    occlusion: Occlusion | None = None,
) -> StudyLog:
    """Read a log, leave out the scans before ``first_scan``, and build its maps.

    max_range: as of ``read_laser_log``. map_every: of how many scans one is in the map. occlusion:
    of the scans to localize, not of those in the map. Raises LogError if no scan is left, MapError
    if no map can be built.
    """
    log = read_laser_log(path, max_range)
    steps = log_steps(log)
    if occlusion is not None:
        steps = occlusion.of(steps)
    if not steps[first_scan:]:
        raise LogError(f"{path}: no scan from scan {first_scan} on: start with an earlier one")
    name = path.name.split(".")[0].removesuffix("-corrected")
    return StudyLog(
        name=name,
        steps=steps[first_scan:],
        map=map_of_log(replace(log, scans=log.scans[::map_every]), RESOLUTION, "all"),
        even_map=map_of_log(log, RESOLUTION, "even"),
        odd_steps=[
            step for number, step in enumerate(steps) if number % 2 and number >= first_scan
        ],
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class RunScore:
    """Figures of one run over a log."""

    rmse: float
    """Root mean square of the position error, m."""
    p95: float
    """95th percentile of the position error, m."""
    heading_rmse: float
    """Root mean square of the heading error, degrees."""
    worst: float
    """Largest position error, m."""
    localized_share: float
    """Share of the scans with health localized."""
    lost_share: float
    lost_at_end: bool
    """Whether the last scan's estimate is lost."""
    inside_xy: float
    """Share of references inside the 95 % ellipse of the position; nan without references."""
    inside: float
    """The same for x, y and heading together."""
    update_ms: float
    """Median time of an update."""


def accuracy(
    logs: Sequence[StudyLog],
    seeds: int,
    *,
    hold_out: bool = False,
    settings: LocalizationSettings | None = None,
    progress: Progress = lambda _: None,
) -> Table:
    """Run every log with every seed from its true start; one row per log: median and worst seed.

    hold_out: on the map of every second scan, localize only the scans between.
    """
    table, done = [], 0
    for log in logs:
        scores = []
        for seed in range(seeds):
            steps, folder = (log.odd_steps, log.even_map) if hold_out else (log.steps, log.map)
            scores.append(_score(log.name, steps, folder, seed, settings))
            done += 1
            progress(done)
        table.append(_accuracy_row(log.name, scores))
    return table


def _score(
    name: str,
    steps: Sequence[LogStep],
    folder: MapFolder,
    seed: int,
    settings: LocalizationSettings | None,
) -> RunScore:
    options = LocalizeOptions(seed=seed, settings=settings or LocalizationSettings())
    result = localize_steps(name, steps, folder, options)
    position = np.array([row.position_error_m for row in result.rows], dtype=np.float64)
    heading = np.array([row.heading_error_deg for row in result.rows], dtype=np.float64)
    inside = result.coverage()
    return RunScore(
        rmse=float(np.sqrt(np.mean(position**2))),
        p95=float(np.percentile(position, 95)),
        heading_rmse=float(np.sqrt(np.mean(heading**2))),
        worst=float(position.max()),
        localized_share=float(np.mean([row.health == Health.LOCALIZED for row in result.rows])),
        lost_share=result.lost_share or 0.0,
        lost_at_end=result.rows[-1].is_lost,
        inside_xy=math.nan if inside is None else inside.xy,
        inside=math.nan if inside is None else inside.pose,
        update_ms=float(np.median([row.update_ms for row in result.rows])),
    )


def _accuracy_row(name: str, scores: Sequence[RunScore]) -> dict[str, object]:
    def median(of: Callable[[RunScore], float]) -> float:
        return float(np.median([of(score) for score in scores]))

    worst = max(scores, key=lambda score: score.rmse)
    return {
        "log": name,
        "seeds": len(scores),
        "rmse_m": median(lambda score: score.rmse),
        "worst_rmse_m": worst.rmse,
        "p95_m": median(lambda score: score.p95),
        "worst_p95_m": max(score.p95 for score in scores),
        "heading_rmse_deg": median(lambda score: score.heading_rmse),
        "worst_heading_deg": max(score.heading_rmse for score in scores),
        "worst_m": max(score.worst for score in scores),
        "localized": float(np.mean([score.localized_share for score in scores])),
        "lost": max(score.lost_share for score in scores),
        "lost_at_end": sum(score.lost_at_end for score in scores),
        "inside_xy_95": float(np.mean([score.inside_xy for score in scores])),
        "inside_pose_95": float(np.mean([score.inside for score in scores])),
        "update_ms": median(lambda score: score.update_ms),
    }


def travel_along(steps: Sequence[LogStep]) -> NDArray[np.float64]:
    """Return the distance travelled up to each step by the references, (n,), m."""
    places = np.array([reference_of(step)[:2] for step in steps])
    return np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(places, axis=0).T))))


def reference_of(step: LogStep) -> NDArray[np.float64]:
    """Return the step's reference pose (x, y, theta), (3,); raises LogError if it has none."""
    if step.reference is None:
        raise LogError("a study needs a reference pose at every scan: take a corrected log")
    return np.array(step.reference)


def run_trial(log: StudyLog, steps: Sequence[LogStep], options: LocalizeOptions) -> LocalizeResult:
    """Localize one trial's scans on the log's map."""
    return localize_steps(log.name, steps, log.map, options)


def spread(count: int, sizes: Sequence[int]) -> Iterator[tuple[int, int]]:
    """Yield ``count`` pairs (sequence, index) spread evenly over sequences of these sizes."""
    ends = np.cumsum(sizes)
    for number in range(count):
        place = int((number + 0.5) * ends[-1] / count)
        which = int(np.searchsorted(ends, place, side="right"))
        yield which, place - int(ends[which] - sizes[which])
