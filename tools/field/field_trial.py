"""The trial: rows run one after the other on a stage, with what they need made before."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path

from robot_agent.config import find_map
from tools.field.acceleration import choose_acceleration
from tools.field.field_row import FieldRow, Outcome
from tools.field.field_stage import FieldStage
from tools.field.installation_rows import INSTALLATION_ROWS
from tools.field.machine_image import cache_folder, machine_image
from tools.field.needed_programs import install_missing
from tools.field.trial_error import TrialError

MAP = "paper_lab"
POSE = "5.0,13.4,0"
"""True start of the robot, m, m, deg: the one of the file that README prints."""


def run_trial(
    rows: Sequence[FieldRow],
    folder: Path,
    rate: float | None,
    report: Callable[[str], None],
    ended: Callable[[FieldRow, Outcome], None],
) -> None:
    """Run rows; ``ended`` is called with each.

    folder: for disks, logs and recordings; an installation found there is used again unless its
    rows are among these. rate: seconds of the machine's clock in a real second, None for the usual.
    Raises TrialError when nothing can be run.
    """
    install_missing(report)
    image = machine_image(cache_folder(), report)
    acceleration = choose_acceleration(rate)
    report(f"machine by {acceleration.name}, its clock at {acceleration.rate:g} of the real one")
    folder = folder.resolve()  # disks name those below them by path
    folder.mkdir(parents=True, exist_ok=True)
    place = find_map(MAP, Path("/"))
    with closing(FieldStage(folder, image, acceleration, place, POSE)) as stage:
        for row in (*_preparation(rows, stage), *rows):
            report(f"{row.name}: {row.what}")
            outcome = run_row(row, stage)
            if row in rows:
                ended(row, outcome)
            elif outcome.complaints:
                raise TrialError(f"{row.name}: {'; '.join(outcome.complaints)}")


def run_row(row: FieldRow, stage: FieldStage) -> Outcome:
    """Run one row; what keeps it from being carried out is a complaint too."""
    outcome = Outcome()
    try:
        row.run(stage, outcome)
    except TrialError as error:
        outcome.complaints.append(f"{error} ({stage.machine_words()})")
        stage.close()
    return outcome


def _preparation(rows: Sequence[FieldRow], stage: FieldStage) -> list[FieldRow]:
    """Return the rows of the installation that are not among these and have left no disk."""
    disks = (stage.bundled, stage.installed)
    missing: list[FieldRow] = []
    for row, disk in zip(INSTALLATION_ROWS, disks, strict=True):
        if row not in rows and (not disk.exists() or missing):
            missing.append(row)
    return missing
