"""Cells of a CSV file that no spreadsheet takes for a formula and no terminal for a command."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

_FORMULA = ("=", "+", "-", "@", "\t", "\r")


def csv_cells(values: Iterable[Any]) -> list[Any]:
    """Return cells for a row: texts neutralised, everything else as it is."""
    return [csv_cell(value) for value in values]


def csv_cell(value: Any) -> Any:
    """Return a value for a cell.

    A text is cleared of control characters, which are escaped, and gets an apostrophe in front,
    which spreadsheets do not show, if it starts as a formula does.
    """
    if not isinstance(value, str):
        return value
    plain = value if value.isprintable() else _escaped(value)
    return f"'{plain}" if value.startswith(_FORMULA) else plain


def _escaped(text: str) -> str:
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)
