"""How much of the disk recordings may take: the oldest runs of a robot make room for the newest."""

from __future__ import annotations

import shutil
from pathlib import Path

from robot_agent.config import RecorderSettings

MEGABYTE = 1_000_000


class RecordingRetention:
    """Deletes a robot's oldest runs as the one being recorded grows. For the recorder's thread."""

    def __init__(self, current: Path, settings: RecorderSettings, older: str = "") -> None:
        """``older`` is the pattern of the names of runs beside ``current`` that may be deleted."""
        self._current = current
        self._settings = settings
        self._older = older

    def make(self) -> str:
        """Delete what must go; return why recording has to end, empty while there is room.

        Raises OSError where the disk does not answer.
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
        """Say what there is too little of."""
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
