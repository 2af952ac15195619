"""What a process holds: open handles, threads, memory."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

_KB_PER_MB = 1024.0


@dataclass(frozen=True, slots=True)
class Footprint:
    """Of one process at one time."""

    handles: int
    threads: int
    memory_mb: float
    """Resident, MB (2^20 bytes)."""


def footprint_of(pid: int) -> Footprint:
    """Return what a process holds now; raises OSError if it has ended."""
    place = Path(f"/proc/{pid}")
    status = dict(line.partition(":")[::2] for line in (place / "status").read_text().splitlines())
    return Footprint(
        len(os.listdir(place / "fd")),  # noqa: PTH208 - names alone: an entry may be gone already
        int(status["Threads"]),
        int(status["VmRSS"].split()[0]) / _KB_PER_MB,
    )
