"""The rows: their names, their choice, and what they read from programs."""

from __future__ import annotations

import pytest

from tools.cli import main
from tools.field.installation_rows import udev_lines
from tools.field.row_list import ROWS, chosen_rows
from tools.field.service_rows import exposure
from tools.field.trial_error import TrialError

PORTS = """\
/dev/ttyUSB0
  serial    TRIALB1
  udev      SUBSYSTEM=="tty", ATTRS{serial}=="TRIALB1", SYMLINK+="patrol/ROLE", MODE="0660"

/dev/ttyUSB1
  serial    TRIALL1
  udev      SUBSYSTEM=="tty", ATTRS{serial}=="TRIALL1", SYMLINK+="patrol/ROLE", MODE="0660"
"""


def test_names_are_unique() -> None:
    names = [row.name for row in ROWS]
    assert len(set(names)) == len(names)


def test_chosen_rows_keep_the_order_of_the_table() -> None:
    assert [row.name for row in chosen_rows(["killed", "boot"])] == ["boot", "killed"]
    assert chosen_rows([]) == list(ROWS)


def test_an_unknown_row_is_refused() -> None:
    with pytest.raises(TrialError, match="nothing: no such row"):
        chosen_rows(["nothing"])


def test_the_list_names_every_row(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["trial", "--list"]) == 0
    listed = [line.split()[0] for line in capsys.readouterr().out.splitlines()]
    assert listed == [row.name for row in ROWS]


def test_rules_are_those_that_patrol_ports_prints() -> None:
    assert udev_lines(PORTS) == (
        'SUBSYSTEM=="tty", ATTRS{serial}=="TRIALB1", SYMLINK+="patrol/base", MODE="0660"\n'
        'SUBSYSTEM=="tty", ATTRS{serial}=="TRIALL1", SYMLINK+="patrol/laser", MODE="0660"\n'
    )


def test_exposure_is_read_from_the_last_line() -> None:
    line = "→ Overall exposure level for patrol@robot1.service: 1.6 OK :-)\n"
    assert exposure(line) == 1.6
    assert exposure("Unit not found") == 10.0
