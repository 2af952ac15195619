"""One measured figure with its unit and its limit."""

from __future__ import annotations

from dataclasses import dataclass

SEED = 1
"""Random seed of every measured run."""
SETTLED_S = 12.0
"""Time after which an agent has connected, localized and started to patrol."""
MEASURED_S = 20.0


@dataclass(frozen=True)
class Figure:
    """One line of the table."""

    name: str
    value: float
    unit: str
    limit: float | None = None
    """Largest value allowed (smallest if ``at_least``); None: no limit, for information."""
    at_least: bool = False
    """Whether the limit is a lower bound."""

    @property
    def kept(self) -> bool:
        """Whether the value is within its limit; True without a limit."""
        if self.limit is None:
            return True
        return self.value >= self.limit if self.at_least else self.value <= self.limit

    def cells(self) -> tuple[str, str, str, str]:
        """Return name, value, limit and verdict as text; the last two are empty without a limit."""
        bound = "at least" if self.at_least else "at most"
        limit = "" if self.limit is None else f"{bound} {self.limit:g}"
        verdict = "" if self.limit is None else ("ok" if self.kept else "MISSED")
        return self.name, f"{self.value:.3g} {self.unit}", limit, verdict
