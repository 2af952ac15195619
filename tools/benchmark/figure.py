"""One figure of the table: what was measured, its unit and its limit."""

from __future__ import annotations

from dataclasses import dataclass

SEED = 1
"""Of every run that is measured."""
SETTLED_S = 12.0
"""An agent has connected, localized and set off by then."""
MEASURED_S = 20.0


@dataclass(frozen=True)
class Figure:
    """One line of the table."""

    name: str
    value: float
    unit: str
    limit: float | None = None
    """The value must not be above it; None: for information."""
    at_least: bool = False
    """The limit is one from below."""

    @property
    def kept(self) -> bool:
        """Whether the limit is kept."""
        if self.limit is None:
            return True
        return self.value >= self.limit if self.at_least else self.value <= self.limit

    def cells(self) -> tuple[str, str, str, str]:
        """Name, value, limit and verdict, for a table."""
        bound = "at least" if self.at_least else "at most"
        limit = "" if self.limit is None else f"{bound} {self.limit:g}"
        verdict = "" if self.limit is None else ("ok" if self.kept else "MISSED")
        return self.name, f"{self.value:.3g} {self.unit}", limit, verdict
