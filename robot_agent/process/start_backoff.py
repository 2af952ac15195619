"""Starts that fail one after the other wait longer and longer, for half a minute at most.

The service is restarted without limit, a second after its end. An agent that fails at once, for
ever, would load the computer and flood the journal; its robot must be back soon all the same when
the cause has gone. systemd 252 cannot lengthen its pauses, so the agent itself waits.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

HEALTHY_S = 60.0
"""An agent that ran this long has not failed at its start."""
PAUSES_S = (0.0, 0.0, 2.0, 4.0, 8.0, 16.0, 30.0)
"""Pause by the number of failed starts before; the last for all more. A robot whose agent was
killed once is back at once, and none is off for more than a minute."""
_FILE = "starts"


class StartBackoff:
    """Counts failed starts of one robot's service in its runtime folder.

    The folder is kept while the service is restarted, and empty after a boot or a stop.
    """

    def __init__(self, environment: Mapping[str, str] = os.environ) -> None:
        """Take the runtime folder from the service manager's environment; without, do nothing."""
        folder = environment.get("RUNTIME_DIRECTORY", "")
        self._file = Path(folder) / _FILE if folder else None
        self.failed = 0
        """Starts that failed one after the other before this one."""

    def begin(self, now: float) -> float:
        """Count a start; return the pause, s, to make before it. now: host's monotonic clock, s.

        A file that cannot be read or written is as good as none: the start must not fail by it.
        """
        if self._file is None:
            return 0.0
        count, begun = self._read()
        # Before ``begun`` in its pause, after it in its first minute.
        self.failed = count + 1 if -PAUSES_S[-1] <= now - begun < HEALTHY_S else 0
        pause = PAUSES_S[min(self.failed, len(PAUSES_S) - 1)]
        try:
            self._file.write_text(f"{self.failed} {now + pause:.3f}")
        except OSError:
            return 0.0
        return pause

    def ended_well(self) -> None:
        """Forget the starts: this one was ended on purpose."""
        if self._file is not None:
            self._file.unlink(missing_ok=True)

    def _read(self) -> tuple[int, float]:
        """Return the failed starts and the time of the last start; long ago if there was none."""
        assert self._file is not None
        try:
            count, begun = self._file.read_text().split()
            return max(int(count), 0), float(begun)
        except (OSError, ValueError):
            return 0, -HEALTHY_S
