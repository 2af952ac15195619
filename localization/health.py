"""Health of the localization: `localized`, `unsure` or `lost`, with hysteresis."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from localization.settings import HealthSettings


class Health(StrEnum):
    """How far the pose can be trusted."""

    LOCALIZED = "localized"
    UNSURE = "unsure"
    LOST = "lost"


@dataclass(frozen=True, slots=True)
class Evidence:
    """What one update says about the estimate."""

    fit: float | None
    """Mean fit of the scan's beams at the estimate, 0..1; None if it has too few to tell."""
    spread: float
    """Standard deviation of the best cluster's position along its worst direction, m."""
    share: float
    """Of the weight in the best cluster, 0..1."""
    through: float = 0.0
    """Share of the beams that pass through mapped walls, 0..1."""
    jump_xy: float = 0.0
    """Between the estimate and where the odometry would put it, m."""
    jump_theta: float = 0.0
    """Likewise, rad."""
    strayed: bool = False
    """Whether the scan fits only beside where the odometry would put it."""
    worth: float = 1.0
    """Of the scan: 1 if taken a step away from the last one, less on the same place."""


_RANK = {Health.LOST: 0, Health.UNSURE: 1, Health.LOCALIZED: 2}
_ENOUGH = 1.0 - 1e-9  # sums of worths are not exact


class HealthMonitor:
    """Judges each update by its evidence; wants several to agree before it changes its mind."""

    def __init__(self, settings: HealthSettings, health: Health = Health.UNSURE) -> None:
        self._settings = settings
        self.health = health
        self._run: list[Health] = []  # verdicts in a row that were all better, or all worse
        self._run_worth = 0.0

    def update(self, evidence: Evidence) -> Health:
        """Return the health after one more update."""
        verdict = self._verdict(evidence)
        change = self._change(verdict)
        if self._run and change * self._change(self._run[0]) <= 0:
            self._forget_run()
        if change != 0:
            self._run.append(verdict)
            self._run_worth += evidence.worth
            needed = self._settings.worsen_after if change < 0 else self._settings.improve_after
            if self._run_worth >= needed * _ENOUGH:
                # What all of the run agree on: the verdict nearest to the present health.
                self.health = min(self._run, key=lambda verdict: abs(self._change(verdict)))
                self._forget_run()
        return self.health

    def _forget_run(self) -> None:
        self._run.clear()
        self._run_worth = 0.0

    def _change(self, verdict: Health) -> int:
        """Return how much better (positive) or worse a verdict is than the present health."""
        return _RANK[verdict] - _RANK[self.health]

    def _verdict(self, evidence: Evidence) -> Health:
        """Judge one update alone; thresholds depend on the present health (hysteresis)."""
        settings = self._settings
        if evidence.fit is None:
            return Health.LOST if self.health is Health.LOST else Health.UNSURE
        lost_limit = settings.found_above if self.health is Health.LOST else settings.lost_below
        if evidence.fit < lost_limit:
            return Health.LOST
        if self.health is Health.LOCALIZED:
            good = (
                evidence.fit >= settings.unsure_below
                and evidence.through <= settings.unsure_through
                and evidence.spread <= settings.unsure_spread
                and evidence.share >= settings.unsure_share
            )
        else:
            good = (
                evidence.fit >= settings.localized_above
                and evidence.through <= settings.localized_through
                and evidence.spread <= settings.localized_spread
                and evidence.share >= settings.localized_share
            )
        steady = (
            not evidence.strayed
            and evidence.jump_xy <= settings.jump_xy
            and evidence.jump_theta <= settings.jump_theta
        )
        return Health.LOCALIZED if good and steady else Health.UNSURE
