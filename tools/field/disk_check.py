"""A disk as a power cut left it: its file system, judged without starting the machine."""

from __future__ import annotations

import subprocess
from pathlib import Path

from tools.field.needed_programs import with_sbin

_REPAIRED = 1
"""Greatest status of ``e2fsck -p`` that needs no person: what a boot does by itself."""


def examine_disk(disk: Path, copy: Path) -> str:
    """Return what is wrong with a disk's file system, empty for nothing.

    copy: place for a raw copy, deleted again. First the journal is replayed as a boot does, then
    everything must be in order.
    """
    _run("qemu-img", "convert", "-q", "-O", "raw", str(disk), str(copy))
    try:
        boot = _run("e2fsck", "-p", str(copy))
        if boot.returncode > _REPAIRED:
            return f"e2fsck -p: status {boot.returncode}: {boot.stdout.strip()[-200:]}"
        full = _run("e2fsck", "-fn", str(copy))
        return "" if full.returncode == 0 else f"e2fsck -fn: {full.stdout.strip()[-200:]}"
    finally:
        copy.unlink(missing_ok=True)


def _run(*command: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        command, capture_output=True, text=True, check=False, timeout=600, env=with_sbin()
    )
