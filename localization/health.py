"""Health of the localization: `localized`, `unsure` or `lost`, with hysteresis."""

from __future__ import annotations

from enum import StrEnum

from localization.settings import HealthSettings


class Health(StrEnum):
    """How far the pose can be trusted."""

    LOCALIZED = "localized"
    UNSURE = "unsure"
    LOST = "lost"


_RANK = {Health.LOST: 0, Health.UNSURE: 1, Health.LOCALIZED: 2}


class HealthMonitor:
    """Judges each update by the scan's fit and the belief's spread; confirms before it changes."""

    def __init__(self, settings: HealthSettings, health: Health = Health.UNSURE) -> None:
        self._settings = settings
        self.health = health
        self._run: list[Health] = []  # verdicts in a row that were all better, or all worse

    def update(self, likelihood: float | None, spread: float, share: float) -> Health:
        """Return the health after one more update.

        likelihood: mean fit of the current scan's beams at the estimate, 0..1, None if it has too
        few to tell; spread: of the best cluster, m; share: of the weight in that cluster, 0..1.
        """
        verdict = self._verdict(likelihood, spread, share)
        if self._run and self._change(verdict) * self._change(self._run[0]) <= 0:
            self._run.clear()
        change = self._change(verdict)
        if change != 0:
            self._run.append(verdict)
        settings = self._settings
        if len(self._run) >= (
            settings.updates_to_worsen if change < 0 else settings.updates_to_improve
        ):
            # What all of the run agree on: the verdict nearest to the present health.
            self.health = min(self._run, key=lambda verdict: abs(self._change(verdict)))
            self._run.clear()
        return self.health

    def _change(self, verdict: Health) -> int:
        """Return how much better (positive) or worse a verdict is than the present health."""
        return _RANK[verdict] - _RANK[self.health]

    def _verdict(self, likelihood: float | None, spread: float, share: float) -> Health:
        """Judge one update alone; thresholds depend on the present health (hysteresis)."""
        settings = self._settings
        if likelihood is None:
            return Health.LOST if self.health is Health.LOST else Health.UNSURE
        lost_limit = settings.found_above if self.health is Health.LOST else settings.lost_below
        if likelihood < lost_limit:
            return Health.LOST
        if self.health is Health.LOCALIZED:
            good = (
                likelihood >= settings.unsure_below
                and spread <= settings.unsure_spread
                and share >= settings.unsure_share
            )
        else:
            good = (
                likelihood >= settings.localized_above
                and spread <= settings.localized_spread
                and share >= settings.localized_share
            )
        return Health.LOCALIZED if good else Health.UNSURE
