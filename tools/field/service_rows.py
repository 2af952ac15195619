"""Rows: the service as systemd sees it, and its journal."""

from __future__ import annotations

import re

from tools.field.field_row import FieldRow, Outcome
from tools.field.field_stage import UNIT, FieldStage
from tools.field.journal import lines_an_hour

MAX_EXPOSURE = 2.0
"""Of 10, as ``systemd-analyze security`` counts."""
WATCHED_S = 180.0
"""Time for which a journal is watched, s: a robot is once round the border in about 170 s."""
MAX_LINES_AN_HOUR = 100.0


def _security(stage: FieldStage, outcome: Outcome) -> None:
    shown = stage.workbench().run(f"systemd-analyze security {UNIT} --no-pager | tail -1")
    found = exposure(shown)
    outcome.note(f"{found:g} of 10")
    outcome.require(found < MAX_EXPOSURE, f"not under {MAX_EXPOSURE:g}")


def exposure(shown: str) -> float:
    """Return the exposure in the last line of ``systemd-analyze security``, of 10."""
    found = re.search(r": ([\d.]+) ", shown)
    return float(found[1]) if found else 10.0


def _journal(stage: FieldStage, outcome: Outcome) -> None:
    stage.patrolling()
    begun, contacts = stage.guest.uptime(), stage.robot.contacts
    stage.clock.sleep(WATCHED_S)
    ended = stage.guest.uptime()
    lines = stage.journal()
    rate = lines_an_hour(lines, begun, ended)
    outcome.note(f"{rate:.0f} lines an hour ({ended - begun:.0f} s watched)")
    if rate >= MAX_LINES_AN_HOUR:
        said = sorted({line.text for line in lines if begun <= line.t < ended})
        outcome.complaints.append(f"not under {MAX_LINES_AN_HOUR:g}: {'; '.join(said)[:400]}")
    outcome.require(stage.robot.contacts == contacts, "contacts")


SERVICE_ROWS = (
    FieldRow("security", "systemd-analyze security", f"under {MAX_EXPOSURE:g} of 10", _security),
    FieldRow(
        "journal",
        f"a healthy patrol for {WATCHED_S:.0f} s",
        f"under {MAX_LINES_AN_HOUR:.0f} lines an hour, no contact",
        _journal,
    ),
)
