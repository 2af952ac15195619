"""Bounds of the disk space for recordings: the oldest runs of a robot are deleted first."""

from __future__ import annotations

import shutil
from pathlib import Path

from robot_agent.config import RecorderSettings
from robot_agent.recording.run_files import RunFiles

MEGABYTE = 1_000_000
KEPT_RUNS = 3
"""Runs that are never deleted, the one being recorded and the latest before it: ours."""


class RecordingRetention:
    """Deletes a robot's oldest runs as the one being recorded grows. For the recorder's thread."""

    def __init__(self, files: RunFiles, settings: RecorderSettings) -> None:
        """files: the runs, of which the oldest may be deleted."""
        self._files = files
        self._settings = settings

    def free_space(self, margin_mb: float = 0.0) -> str:
        """Delete runs until the bounds hold; return why they cannot, empty on success.

        margin_mb: room wanted besides. Nothing is deleted where deleting does not reach the
        bounds; recording has to pause then. Raises OSError on an error of the disk.
        """
        older = self._files.older()
        deletable = older[: max(len(older) - (KEPT_RUNS - 1), 0)]
        taken = sum(_size(path) for path in (*older, self._files.path)) + margin_mb * MEGABYTE
        free = shutil.disk_usage(self._files.path.parent).free - margin_mb * MEGABYTE
        for count, path in enumerate([*deletable, None]):
            reason = self._shortage(taken, free)
            if not reason:
                for gone in deletable[:count]:
                    gone.unlink(missing_ok=True)
                return ""
            if path is not None:
                taken -= _size(path)
                free += _freed(path)
        return reason

    def _shortage(self, taken: float, free: float) -> str:
        """Return which bound is exceeded, with the setting; empty if none is.

        taken: by all runs, bytes. free: on the disk, bytes.
        """
        if taken > self._settings.keep_mb * MEGABYTE:
            return (
                f"recorder.keep_mb = {self._settings.keep_mb:g} is used up by the last {KEPT_RUNS} "
                "runs; move them away or raise it"
            )
        if free < self._settings.leave_free_mb * MEGABYTE:
            return (
                f"the disk has too little room, recorder.leave_free_mb = "
                f"{self._settings.leave_free_mb:g}; make room"
            )
        return ""


def _size(path: Path) -> int:
    """Return a file's size, bytes; 0 if another process has removed it."""
    try:
        return path.stat().st_size
    except FileNotFoundError:
        return 0


def _freed(path: Path) -> int:
    """Return the space that deleting a file gives back, bytes."""
    try:
        found = path.stat()
    except FileNotFoundError:
        return 0
    return found.st_blocks * 512 if found.st_nlink == 1 else 0
