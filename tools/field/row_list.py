"""All rows of the field table, in the order they are run, and their choice by name."""

from __future__ import annotations

from collections.abc import Sequence

from tools.field.boot_rows import BOOT_ROWS
from tools.field.fault_rows import FAULT_ROWS
from tools.field.field_row import FieldRow
from tools.field.installation_rows import INSTALLATION_ROWS
from tools.field.mistake_rows import MISTAKE_ROWS
from tools.field.power_rows import POWER_ROWS
from tools.field.service_rows import SERVICE_ROWS
from tools.field.trial_error import TrialError

ROWS: tuple[FieldRow, ...] = (
    *INSTALLATION_ROWS,
    *SERVICE_ROWS[:1],
    *MISTAKE_ROWS,
    *BOOT_ROWS,
    *FAULT_ROWS,
    *SERVICE_ROWS[1:],
    *POWER_ROWS,
)


def chosen_rows(names: Sequence[str]) -> list[FieldRow]:
    """Return the rows of these names in the table's order, all for none; raises TrialError."""
    unknown = [name for name in names if name not in {row.name for row in ROWS}]
    if unknown:
        raise TrialError(f"--only {unknown[0]}: no such row; `patrol trial --list` names them")
    return [row for row in ROWS if not names or row.name in names]
