"""A row of the field table: what is done, what must hold, and what was found."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from tools.field.field_stage import FieldStage


@dataclass(slots=True)
class Outcome:
    """What a row has measured, in words, and what did not hold."""

    measured: list[str] = field(default_factory=list)
    complaints: list[str] = field(default_factory=list)

    def note(self, words: str) -> None:
        """Add a measured figure."""
        self.measured.append(words)

    def require(self, holds: bool, complaint: str) -> None:
        """Add a complaint unless something holds."""
        if not holds:
            self.complaints.append(complaint)

    def within(self, what: str, seconds: float | None, limit: float) -> None:
        """Note a time, s, that must not be None (did not happen) and keep its limit."""
        self.note(f"{what} {'never' if seconds is None else f'{seconds:.1f} s'}")
        if seconds is None or seconds > limit:
            self.complaints.append(f"{what}: over {limit:g} s")


@dataclass(frozen=True, slots=True)
class FieldRow:
    """One row; ``run`` does it on the stage and judges it."""

    name: str
    what: str
    must: str
    run: Callable[[FieldStage, Outcome], None]


HEADINGS = ("row", "what was done", "what must hold", "measured", "verdict")


def markdown(done: Sequence[tuple[FieldRow, Outcome]]) -> str:
    """Return the table in Markdown."""
    lines = [HEADINGS, tuple("---" for _ in HEADINGS), *(_cells(*each) for each in done)]
    return "".join(f"| {' | '.join(cells)} |\n" for cells in lines)


def verdict(outcome: Outcome) -> str:
    """Return ok, or what did not hold."""
    return "; ".join(outcome.complaints) or "ok"


def _cells(row: FieldRow, outcome: Outcome) -> tuple[str, ...]:
    measured = "; ".join(outcome.measured) or "-"
    cells = (row.name, row.what, row.must, measured, verdict(outcome))
    return tuple(" ".join(cell.split()).replace("|", "/") for cell in cells)
