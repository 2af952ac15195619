"""Limits a process to a share of one core by cgroups, to emulate a slower computer."""

from __future__ import annotations

import os
import time
from contextlib import suppress
from pathlib import Path

PERIOD_S = 0.01
"""Period of the quota. With the kernel's default of 0.1 s a process limited to a fifth would be
frozen for 0.08 s at a time instead of running slowly."""
CGROUPS = Path("/sys/fs/cgroup")
_US = 1_000_000
_GIVE_UP_S = 2.0


class CpuLimitError(RuntimeError):
    """No share can be set on this system; the message contains the remedy."""


class CpuLimit:
    """A control group: ``hold`` adds processes to it, ``close`` removes it.

    Works with the second version of cgroups (cpu.max) and the first (cpu.cfs_quota_us).
    """

    def __init__(self, share: float, cgroups: Path = CGROUPS) -> None:
        """Make the group. share: of one core, 0 to 1. cgroups: mount point of the cgroups.

        Raises CpuLimitError if no group can be made.
        """
        name = f"patrol-{os.getpid()}"
        second = (cgroups / "cgroup.controllers").exists()
        self._folder = (cgroups if second else cgroups / "cpu") / name
        quota, period = round(share * PERIOD_S * _US), round(PERIOD_S * _US)
        try:
            self._folder.mkdir()
            if second:
                (self._folder / "cpu.max").write_text(f"{quota} {period}")
            else:
                (self._folder / "cpu.cfs_period_us").write_text(str(period))
                (self._folder / "cpu.cfs_quota_us").write_text(str(quota))
        except OSError as error:
            self.close()
            raise CpuLimitError(
                f"no control group can be made in {self._folder.parent} ({error.strerror}): run "
                "this as root, or beneath systemd-run --user --scope -p Delegate=yes"
            ) from None

    def hold(self, pid: int) -> None:
        """Limit a process with all its present and future threads."""
        (self._folder / "cgroup.procs").write_text(str(pid))

    def close(self) -> None:
        """Remove the group; its processes must have ended."""
        give_up = time.monotonic() + _GIVE_UP_S
        while self._folder.exists() and time.monotonic() < give_up:
            with suppress(OSError):  # the kernel releases the last process a little later
                self._folder.rmdir()
                return
            time.sleep(0.01)
