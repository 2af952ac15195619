"""Health of the localization: `localized`, `unsure` or `lost`, with hysteresis."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from localization.scan_check import Fit

# Thresholds between the states, with hysteresis: those to improve are stricter.
UNSURE_BELOW = 0.6  # mean fit of the scan
LOCALIZED_ABOVE = 0.7
LOST_BELOW = 0.45
FOUND_ABOVE = 0.5
UNSURE_WALL_CROSSING = 0.4  # share of the beams that pass through mapped walls
LOCALIZED_WALL_CROSSING = 0.25
UNSURE_SPREAD = 0.4  # m; standard deviation of the best cluster along its worst direction
LOCALIZED_SPREAD = 0.3  # m
UNSURE_SHARE = 0.7  # of the weight in the best cluster
LOCALIZED_SHARE = 0.85
MAX_JUMP_XY = 0.5  # m between the estimate and the last one carried forward by odometry
MAX_JUMP_THETA = 0.5  # rad; a scan with a larger jump is unsure
WORSEN_AFTER = 1.3  # scans in a row, weighted by their information
IMPROVE_AFTER = 4.0  # likewise
RETURN_AFTER = 1.3  # likewise, of a pose that was localized and is the same: it fits again


class Health(StrEnum):
    """Health of the pose estimate."""

    LOCALIZED = "localized"
    UNSURE = "unsure"
    LOST = "lost"


@dataclass(frozen=True, slots=True)
class Evidence:
    """Evidence of one update about the estimate."""

    fit: Fit | None
    """Of the scan at the estimate; None if it has too few beams."""
    spread: float
    """Standard deviation of the best cluster's position along its worst direction, m."""
    share: float
    """Of the weight in the best cluster, 0..1."""
    wall_crossing: float = 0.0
    """Share of the beams that pass through mapped walls, 0..1."""
    jump_xy: float = 0.0
    """Between the estimate and the last one carried forward by odometry, m."""
    jump_theta: float = 0.0
    """Likewise, rad."""
    relocated: bool = False
    """Whether the scan fits only away from the pose that odometry leads to."""
    information: float = 1.0
    """Weight of the scan: 1 if taken a step away from the last one, less at the same place."""


_RANK = {Health.LOST: 0, Health.UNSURE: 1, Health.LOCALIZED: 2}
_ENOUGH = 1.0 - 1e-9  # sums of information weights are not exact


class HealthMonitor:
    """Classifies each update by its evidence; the health changes after several equal ones in a row.

    Scans taken a step apart count in full, those from the same place in part (their information
    weight).
    """

    def __init__(
        self,
        health: Health = Health.UNSURE,
        *,
        worsen_after: float = WORSEN_AFTER,
        improve_after: float = IMPROVE_AFTER,
    ) -> None:
        """Start with a health. worsen_after, improve_after: scans in a row that change it."""
        self._worsen_after, self._improve_after = worsen_after, improve_after
        self.health = health
        # Whether the pose was localized, and neither lost nor moved away from since.
        self._known = health is Health.LOCALIZED
        # Verdicts in a row that were all better, or all worse, with the information of their scans.
        self._run: list[tuple[Health, float]] = []

    @property
    def promising(self) -> bool:
        """Whether the latest update, by itself, was that of a localized pose, but health is not."""
        return bool(self._run) and self._run[-1][0] is Health.LOCALIZED

    def update(self, evidence: Evidence) -> Health:
        """Return the health after one more update."""
        self.health, self._run = self._after(evidence)
        stays = self._known and self.health is not Health.LOST and _is_steady(evidence)
        self._known = self.health is Health.LOCALIZED or stays
        return self.health

    def preview(self, evidence: Evidence) -> Health:
        """Return what ``update`` would return, without changing the state."""
        return self._after(evidence)[0]

    def _after(self, evidence: Evidence) -> tuple[Health, list[tuple[Health, float]]]:
        """Return health and run after one more update."""
        verdict = self._verdict(evidence)
        change = _change(self.health, verdict)
        if change == 0:
            return self.health, []
        goes_on = bool(self._run) and change * _change(self.health, self._run[0][0]) > 0
        run = [*(self._run if goes_on else []), (verdict, evidence.information)]
        if change > 0:
            needed = RETURN_AFTER if self._known else self._improve_after
        else:
            needed = self._worsen_after
        if sum(information for _, information in run) < needed * _ENOUGH:
            return self.health, run
        # The verdict of the run nearest to the present health: all others are farther away.
        health = min((each for each, _ in run), key=lambda each: abs(_change(self.health, each)))
        return health, _beyond(run, health, change)

    def _verdict(self, evidence: Evidence) -> Health:
        """Classify one update alone; thresholds depend on the present health (hysteresis)."""
        if evidence.fit is None:
            return Health.LOST if self.health is Health.LOST else Health.UNSURE
        lost_limit = FOUND_ABOVE if self.health is Health.LOST else LOST_BELOW
        if evidence.fit.fit_without_dynamic < lost_limit:
            return Health.LOST
        if self.health is Health.LOCALIZED:
            good = (
                evidence.fit.fit_without_dynamic >= UNSURE_BELOW
                and evidence.wall_crossing <= UNSURE_WALL_CROSSING
                and evidence.spread <= UNSURE_SPREAD
                and evidence.share >= UNSURE_SHARE
            )
        else:
            # People may occlude the map of a known pose, but not while becoming localized.
            fit = evidence.fit.fit_without_dynamic if self._known else evidence.fit.whole
            good = (
                fit >= LOCALIZED_ABOVE
                and evidence.wall_crossing <= LOCALIZED_WALL_CROSSING
                and evidence.spread <= LOCALIZED_SPREAD
                and evidence.share >= LOCALIZED_SHARE
            )
        return Health.LOCALIZED if good and _is_steady(evidence) else Health.UNSURE


def _is_steady(evidence: Evidence) -> bool:
    """Whether the pose is the last one carried forward."""
    return (
        not evidence.relocated
        and evidence.jump_xy <= MAX_JUMP_XY
        and evidence.jump_theta <= MAX_JUMP_THETA
    )


def _change(before: Health, after: Health) -> int:
    """Return the number of ranks by which ``after`` is better (positive) or worse (negative)."""
    return _RANK[after] - _RANK[before]


def _beyond(
    run: list[tuple[Health, float]], health: Health, change: int
) -> list[tuple[Health, float]]:
    """Return the newest verdicts of a run beyond a health, which count for a further change."""
    kept = len(run)
    while kept and _change(health, run[kept - 1][0]) * change > 0:
        kept -= 1
    return run[kept:]
