"""Counts a robot's runs: its computer has no clock battery, so the time cannot tell their order."""

from __future__ import annotations

import fcntl
import os
import re
from pathlib import Path

_WHOLE = re.compile(rb"(\d{6})\n")
"""A file written whole; anything else is from a power cut and counts for nothing."""


def next_number(path: Path, used: int) -> int:
    """Reserve the number of a new run in a counter file, made if missing.

    used: largest number known from elsewhere, which a missing or damaged file falls back to. No two
    processes get the same number. Raises OSError if the file cannot be written.
    """
    with os.fdopen(os.open(path, os.O_RDWR | os.O_CREAT, 0o644), "r+b") as file:
        fcntl.flock(file, fcntl.LOCK_EX)  # let go by closing, or by the end of the process
        whole = _WHOLE.fullmatch(file.read())
        number = max(used, int(whole[1]) if whole else 0) + 1
        file.seek(0)
        file.write(b"%06d\n" % number)
        file.truncate()
        file.flush()
        os.fsync(file.fileno())
    return number
