"""Hostile files cost one line each, and no more memory than other files."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any

import pytest

MEMORY_MB = 500
READABLE = "readable up to byte"


@pytest.fixture(scope="module")
def rows(tmp_path_factory: pytest.TempPathFactory) -> list[dict[str, Any]]:
    """What each command said, from a process of its own that runs them all."""
    folder = tmp_path_factory.mktemp("hostile")
    command = [sys.executable, "-m", "tests.tools.hostile_files", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=110, check=False)
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]


def test_each_is_refused_by_one_line_or_used_as_far_as_it_is_whole(
    rows: list[dict[str, Any]],
) -> None:
    assert len(rows) > 50
    for row in rows:
        lines = row["told"].splitlines()
        if row["status"] == 0:  # what is whole of a recording or a log is used
            assert ", " in row["name"], row
            continue
        assert row["status"] in (1, 78), row
        assert len(lines) == 1, row
        assert len(lines[0]) < 500, row
        assert "/hostile" in lines[0], row


def test_damaged_recordings_say_where(rows: list[dict[str, Any]]) -> None:
    for row in rows:
        if row["name"].endswith(("report", "replay")) and "undefined" not in row["name"]:
            assert READABLE in row["told"], row


def test_memory_stays_bounded(rows: list[dict[str, Any]]) -> None:
    assert max(row["memory_mb"] for row in rows) < MEMORY_MB
