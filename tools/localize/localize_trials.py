"""Trials of the localizer: global localization, kidnapped robot, slipping and frozen odometry."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from localization.health import Health
from localization.settings import LocalizationSettings
from maps.pose import Pose
from tools.localize.localize import LocalizeOptions, Progress
from tools.localize.localize_result import LocalizeResult
from tools.localize.localize_study import (
    StudyLog,
    Table,
    reference_of,
    run_trial,
    spread,
    travel_along,
)
from tools.logs.carmen import LogError
from tools.logs.log_step import LogStep

RIGHT_M = 0.5
RIGHT_DEG = 15.0
"""A pose is right if its errors are below both."""
START_TRAVEL = 15.0
"""Travel, m, within which an unknown start must be localized."""
NOTICE_TRAVEL = 2.0
"""Travel, m, within which a kidnapped robot's health must leave localized."""
RECOVER_TRAVEL = 20.0
"""Travel, m, within which it must be localized again."""
WATCHED_TRAVEL = 30.0
"""Travel, m, after an unknown start in which wrong poses with health localized are counted."""
TRACKED_SCANS = 25
"""Scans of plain tracking before a kidnap or an odometry failure."""
KIDNAP_DISTANCE = 5.0
"""Smallest distance of a kidnap, m."""
FROZEN_TURN = math.radians(20.0)
"""Turn of the robot, rad, while its odometry is frozen."""
FROZEN_TRAVEL = 1.0
"""Largest travel meanwhile, m."""
SLIP_SHARE = 0.3
"""Share of the odometry's distance that is not travelled."""
SLIP_TRAVEL = 10.0
"""Length of a stretch with slipping wheels, m."""


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """One trial, scan by scan, (n,) each."""

    travel: NDArray[np.float64]
    """Travel since the trial's event, m; negative before it."""
    error: NDArray[np.float64]
    """Position error, m."""
    right: NDArray[np.bool_]
    localized: NDArray[np.bool_]

    @property
    def found_after(self) -> float:
        """Travel, m, at which the pose is first right with health localized; inf if never."""
        good = np.flatnonzero(self.right & self.localized & (self.travel >= 0.0))
        return float(self.travel[good[0]]) if good.size else math.inf

    @property
    def wrong_and_localized(self) -> bool:
        """Whether a wrong pose had health localized after the event."""
        return bool((~self.right & self.localized & (self.travel >= 0.0)).any())

    @property
    def doubted_after(self) -> float:
        """Travel, m, at which the health was first not localized; inf if never."""
        doubted = np.flatnonzero(~self.localized & (self.travel >= 0.0))
        return float(self.travel[doubted[0]]) if doubted.size else math.inf

    @property
    def summary(self) -> dict[str, object]:
        """The outcome for JSON; null: never."""
        return {
            "doubted_after_m": _finite(self.doubted_after),
            "right_and_localized_after_m": _finite(self.found_after),
            "wrong_and_localized_scans": int(
                np.count_nonzero(~self.right & self.localized & (self.travel >= 0.0))
            ),
        }


def _finite(travel: float) -> float | None:
    return travel if math.isfinite(travel) else None


def outcome(result: LocalizeResult, steps: Sequence[LogStep], event: int = 0) -> Outcome:
    """Return the outcome of a run; event: index of the scan from which travel counts."""
    travel = travel_along(steps[event:])
    rows = result.rows
    error = np.array([row.position_error_m for row in rows], dtype=np.float64)
    heading = np.array([row.heading_error_deg for row in rows], dtype=np.float64)
    return Outcome(
        travel=np.concatenate((np.full(event, -1.0), travel)),
        error=error,
        right=(error < RIGHT_M) & (heading < RIGHT_DEG),
        localized=np.array([row.health == Health.LOCALIZED for row in rows]),
    )


def global_starts(
    logs: Sequence[StudyLog],
    trials: int,
    settings: LocalizationSettings,
    progress: Progress = lambda _: None,
) -> tuple[Table, list[Outcome]]:
    """Run global localization from scans spread over the logs.

    Returns a table with one row per log and one of all, and the outcomes.
    """
    last_starts = [_last_start(log.steps, START_TRAVEL) for log in logs]
    outcomes: list[tuple[str, Outcome]] = []
    for seed, (which, start) in enumerate(spread(trials, last_starts)):
        log = logs[which]
        steps = _within(log.steps[start:], WATCHED_TRAVEL)
        options = LocalizeOptions(seed=seed, anywhere=True, settings=settings)
        outcomes.append((log.name, outcome(run_trial(log, steps, options), steps)))
        progress(seed + 1)
    return _by_log(outcomes, _start_row), [found for _, found in outcomes]


def _start_row(outcomes: Sequence[Outcome]) -> dict[str, object]:
    found = np.array([trial.found_after for trial in outcomes])
    return {
        "trials": len(outcomes),
        "right_within_15_m": int(np.count_nonzero(found <= START_TRAVEL)),
        "wrong_and_localized": sum(trial.wrong_and_localized for trial in outcomes),
        "median_m": float(np.median(found)),
        "worst_m": float(found.max()),
    }


def kidnaps(
    logs: Sequence[StudyLog],
    trials: int,
    settings: LocalizationSettings,
    progress: Progress = lambda _: None,
) -> tuple[Table, list[Outcome]]:
    """Track, move the robot elsewhere (kidnap) and go on.

    Returns a table with one row per log and one of all, and the outcomes.
    """
    outcomes: list[tuple[str, Outcome]] = []
    sizes = [len(log.steps) - TRACKED_SCANS for log in logs]
    for seed, (which, start) in enumerate(spread(trials, sizes)):
        log = logs[which]
        before = log.steps[start : start + TRACKED_SCANS]
        steps = kidnapped_steps(before, log.steps, np.random.default_rng(seed), RECOVER_TRAVEL)
        options = LocalizeOptions(seed=seed, settings=settings)
        result = run_trial(log, steps, options)
        outcomes.append((log.name, outcome(result, steps, TRACKED_SCANS)))
        progress(seed + 1)
    return _by_log(outcomes, _kidnap_row), [found for _, found in outcomes]


def _kidnap_row(outcomes: Sequence[Outcome]) -> dict[str, object]:
    doubted = np.array([trial.doubted_after for trial in outcomes])
    again = np.array([trial.found_after for trial in outcomes])
    return {
        "trials": len(outcomes),
        "noticed_within_2_m": int(np.count_nonzero(doubted <= NOTICE_TRAVEL)),
        "recovered_within_20_m": int(np.count_nonzero(again <= RECOVER_TRAVEL)),
        "both": int(np.count_nonzero((doubted <= NOTICE_TRAVEL) & (again <= RECOVER_TRAVEL))),
        "wrong_and_localized_at_end": sum(
            bool(trial.localized[-1] and not trial.right[-1]) for trial in outcomes
        ),
        "median_m": float(np.median(again)),
    }


def kidnapped_steps(
    before: Sequence[LogStep],
    steps: Sequence[LogStep],
    rng: np.random.Generator,
    travel: float = math.inf,
) -> list[LogStep]:
    """Return steps that continue from another place after ``before``, for a travel, m.

    Odometry and time stamps are continuous. Raises LogError if there is no suitable other place.
    """
    last = before[-1]
    target = _kidnap_target(steps, last, rng)
    after = _within(steps[target:], travel)
    shift = last.odometry.compose(after[0].odometry.inverse())
    later = last.t - after[0].t
    if len(before) > 1:
        later += last.t - before[-2].t
    return [
        *before,
        *(replace(step, t=step.t + later, odometry=shift.compose(step.odometry)) for step in after),
    ]


def frozen_turns(
    logs: Sequence[StudyLog],
    trials: int,
    settings: LocalizationSettings,
    progress: Progress = lambda _: None,
    turn: float = FROZEN_TURN,
) -> tuple[Table, list[Outcome]]:
    """Freeze the odometry over turns, rad.

    Returns a table with one row per log and one of all, and the outcomes.
    """
    stretches = [_turns(log.steps, turn) for log in logs]
    return _odometry_trials(logs, stretches, _frozen, trials, settings, progress)


def slips(
    logs: Sequence[StudyLog],
    trials: int,
    settings: LocalizationSettings,
    progress: Progress = lambda _: None,
) -> tuple[Table, list[Outcome]]:
    """Let the wheels slip by 30 % over stretches of 10 m.

    Returns a table with one row per log and one of all, and the outcomes.
    """
    stretches = []
    for log in logs:
        travel = travel_along(log.steps)
        ends = np.searchsorted(travel, travel + SLIP_TRAVEL)
        whole = [(i, int(end)) for i, end in enumerate(ends) if end < len(travel)]
        stretches.append([pair for pair in whole if pair[0] >= TRACKED_SCANS])
    return _odometry_trials(logs, stretches, _slipping, trials, settings, progress)


def _odometry_trials(
    logs: Sequence[StudyLog],
    stretches: Sequence[Sequence[tuple[int, int]]],
    distort: Callable[[Pose], Pose],
    trials: int,
    settings: LocalizationSettings,
    progress: Progress,
) -> tuple[Table, list[Outcome]]:
    outcomes: list[tuple[str, Outcome]] = []
    for seed, (which, number) in enumerate(spread(trials, [len(found) for found in stretches])):
        log, (first, last) = logs[which], stretches[which][number]
        begin = first - TRACKED_SCANS
        steps = with_distorted_odometry(
            log.steps[begin : last + TRACKED_SCANS], TRACKED_SCANS, last - begin, distort
        )
        result = run_trial(log, steps, LocalizeOptions(seed=seed, settings=settings))
        outcomes.append((log.name, outcome(result, steps, TRACKED_SCANS)))
        progress(seed + 1)
    return _by_log(outcomes, _odometry_row), [found for _, found in outcomes]


def _odometry_row(outcomes: Sequence[Outcome]) -> dict[str, object]:
    worst = np.array([trial.error[trial.travel >= 0.0].max() for trial in outcomes])
    return {
        "trials": len(outcomes),
        "under_0.3_m": int(np.count_nonzero(worst < 0.3)),
        "median_worst_m": float(np.median(worst)),
        "worst_m": float(worst.max()),
    }


def with_distorted_odometry(
    steps: Sequence[LogStep], first: int, last: int, distort: Callable[[Pose], Pose]
) -> list[LogStep]:
    """Return steps with ``distort`` applied to odometry increments of scans first + 1 to last."""
    odometry, changed = steps[0].odometry, [steps[0]]
    for number in range(1, len(steps)):
        increment = steps[number - 1].odometry.between(steps[number].odometry)
        odometry = odometry.compose(distort(increment) if first < number <= last else increment)
        changed.append(replace(steps[number], odometry=odometry))
    return changed


def _frozen(_increment: Pose) -> Pose:
    return Pose(0.0, 0.0, 0.0)


def _slipping(increment: Pose) -> Pose:
    """Return the odometry increment of slipping wheels for a true ``increment``."""
    counted = 1.0 / (1.0 - SLIP_SHARE)
    return Pose(counted * increment.x, counted * increment.y, increment.theta)


def _turns(steps: Sequence[LogStep], turn: float) -> list[tuple[int, int]]:
    """Return the stretches (first, last scan) that turn so far, rad, within FROZEN_TRAVEL."""
    travel = travel_along(steps)
    heading = np.unwrap([reference_of(step)[2] for step in steps])
    found, first = [], TRACKED_SCANS
    while first < len(steps) - 1:
        turned = np.abs(heading[first:] - heading[first]) >= turn
        last = first + int(turned.argmax())
        if turned.any() and travel[last] - travel[first] <= FROZEN_TRAVEL:
            found.append((first, last))
            first = last
        first += 1
    return found


def _within(steps: Sequence[LogStep], travel: float) -> Sequence[LogStep]:
    """Return the steps within a travel, m, from the first."""
    return steps[: int(np.searchsorted(travel_along(steps), travel, side="right"))]


def _last_start(steps: Sequence[LogStep], travel: float) -> int:
    """Return the number of scans that are followed by at least a travel, m."""
    along = travel_along(steps)
    return int(np.count_nonzero(along <= along[-1] - travel))


def _kidnap_target(steps: Sequence[LogStep], taken_at: LogStep, rng: np.random.Generator) -> int:
    """Draw the scan a robot is moved to: KIDNAP_DISTANCE away, RECOVER_TRAVEL before the end."""
    places = np.array([reference_of(step)[:2] for step in steps])
    away = np.hypot(*(places - reference_of(taken_at)[:2]).T)
    far = np.flatnonzero(away >= KIDNAP_DISTANCE)
    usable = far[far < _last_start(steps, RECOVER_TRAVEL)]
    if usable.size == 0:
        raise LogError(
            f"a kidnapped robot needs a scan {KIDNAP_DISTANCE:g} m away with "
            f"{RECOVER_TRAVEL:g} m of travel after it: take a longer log"
        )
    return int(rng.choice(usable))


def _by_log(
    outcomes: Sequence[tuple[str, Outcome]], row: Callable[[Sequence[Outcome]], dict[str, object]]
) -> Table:
    names = list(dict.fromkeys(name for name, _ in outcomes))
    table = [
        {"log": name, **row([trial for owner, trial in outcomes if owner == name])}
        for name in names
    ]
    if len(names) > 1:
        table.append({"log": "all", **row([trial for _, trial in outcomes])})
    return table
