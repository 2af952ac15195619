"""Hostile files cost one line each, and no more memory than other files."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.tools.hostile_files import GROUPS

MEMORY_MB = 500
COMMANDS = {"map_folders": 18, "logs": 14, "recordings": 18, "texts": 4}  # at least
READABLE = "readable up to byte"


@pytest.mark.parametrize("group", GROUPS)
def test_each_is_refused_by_one_line_or_used_as_far_as_it_is_whole(
    tmp_path: Path, group: str
) -> None:
    rows = what_is_said(tmp_path, group)
    assert len(rows) >= COMMANDS[group]
    for row in rows:
        assert row["memory_mb"] < MEMORY_MB, row
        is_refused_or_used(row)


def what_is_said(folder: Path, group: str) -> list[dict[str, Any]]:
    """Return what each command of a group said, from a process of its own that runs them all."""
    hostile = folder / "hostile"
    hostile.mkdir()
    command = [sys.executable, "-m", "tests.tools.hostile_files", group, str(hostile)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=110, check=False)
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]


def is_refused_or_used(row: dict[str, Any]) -> None:
    """Check what was told of one file; of a damaged recording, where its damage begins."""
    lines = row["told"].splitlines()
    if row["name"].endswith(("report", "replay")) and "undefined" not in row["name"]:
        assert READABLE in row["told"], row
    if row["status"] == 0:  # what is whole of a recording or a log is used
        assert ", " in row["name"], row
        return
    assert row["status"] in (1, 78), row
    assert len(lines) == 1, row
    assert len(lines[0]) < 500, row
    assert "/hostile" in lines[0], row
