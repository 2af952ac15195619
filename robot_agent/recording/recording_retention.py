"""Bounds of the disk space for recordings: the oldest runs of a robot are deleted first."""

from __future__ import annotations

import shutil
from pathlib import Path

from robot_agent.config import RecorderSettings

MEGABYTE = 1_000_000


class RecordingRetention:
    """Deletes a robot's oldest runs as the one being recorded grows. For the recorder's thread."""

    def __init__(self, current: Path, settings: RecorderSettings, older: str = "") -> None:
        """older: glob pattern of the runs beside ``current`` that may be deleted; empty: none."""
        self._current = current
        self._settings = settings
        self._older = older

    def free_space(self) -> str:
        """Delete runs until the bounds hold; return why that failed, empty on success.

        Recording has to end on failure. Raises OSError on an error of the disk.
        """
        older = self._oldest_first()
        while reason := self._shortage(older):
            if not older:
                return reason
            older.pop(0).unlink(missing_ok=True)
        return ""

    def _oldest_first(self) -> list[Path]:
        if not self._older:
            return []
        found = [path for path in self._current.parent.glob(self._older) if path != self._current]
        return sorted(found, key=lambda path: (path.stat().st_mtime_ns, path.name))

    def _shortage(self, older: list[Path]) -> str:
        """Return which bound is exceeded, with the setting; empty if none is."""
        taken = sum(path.stat().st_size for path in (*older, self._current))
        if taken > self._settings.keep_mb * MEGABYTE:
            return f"recorder.keep_mb = {self._settings.keep_mb:g} is used up by this run alone"
        free = shutil.disk_usage(self._current.parent).free
        if free < self._settings.leave_free_mb * MEGABYTE:
            return (
                f"the disk has {free / MEGABYTE:.0f} MB left, "
                f"recorder.leave_free_mb = {self._settings.leave_free_mb:g}"
            )
        return ""
