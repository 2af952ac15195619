"""The blocks of a report's sections: content without layout, which the template defines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from matplotlib.figure import Figure as MatplotlibFigure

from tools.report.style import Drawing, drawing


@dataclass(frozen=True, slots=True)
class Paragraph:
    """A line of text; kind is its class in the style sheet."""

    form: ClassVar = "paragraph"
    text: str
    kind: str


@dataclass(frozen=True, slots=True)
class Figure:
    """A drawing with its caption."""

    form: ClassVar = "figure"
    drawn: MatplotlibFigure
    caption: str

    @property
    def drawing(self) -> Drawing:
        """The drawing for the page."""
        return drawing(self.drawn)


@dataclass(frozen=True, slots=True)
class Cell:
    """A text in a table."""

    text: str

    @property
    def number(self) -> bool:
        """Whether to align it as a number: it begins with a digit or minus."""
        return self.text[:1].isdigit() or self.text[:1] == "-"


@dataclass(frozen=True, slots=True)
class Row:
    """A row of a table; kind is its class in the style sheet, empty for none."""

    cells: Sequence[Cell]
    kind: str = ""


@dataclass(frozen=True, slots=True)
class Table:
    """Rows below column headings."""

    form: ClassVar = "table"
    heads: Sequence[str]
    rows: Sequence[Row]


@dataclass(frozen=True, slots=True)
class Folded:
    """A table that is unfolded by a click on its summary."""

    form: ClassVar = "folded"
    summary: str
    table: Table
    is_open: bool


Block = Paragraph | Figure | Table | Folded


def table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> Table:
    """Return a table of texts."""
    return Table(heads, [row(cells) for cells in rows])


def row(texts: Sequence[str], kind: str = "") -> Row:
    """Return a row of texts."""
    return Row([Cell(text) for text in texts], kind)
