"""Holds a process to a share of one core, as a slower computer would, by the kernel's cgroups."""

from __future__ import annotations

import os
import time
from contextlib import suppress
from pathlib import Path

PERIOD_S = 0.01
"""The share is given anew each period. The kernel's usual 0.1 s would make a frozen computer of a
slow one: held to a fifth, a process would stand still for 0.08 s at a time."""
CGROUPS = Path("/sys/fs/cgroup")
_US = 1_000_000
_GIVE_UP_S = 2.0


class CpuLimitError(RuntimeError):
    """No share can be set here; the message says what can be done."""


class CpuLimit:
    """A control group of its own; ``hold`` puts processes into it, ``close`` ends it.

    Works with the second version of cgroups (cpu.max) and the first (cpu.cfs_quota_us).
    """

    def __init__(self, share: float, cgroups: Path = CGROUPS) -> None:
        """Take the share, 0 to 1, of one core, and where the system's groups are.

        Raises CpuLimitError where no group can be made.
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
        """Hold a process, with all threads it has and will have."""
        (self._folder / "cgroup.procs").write_text(str(pid))

    def close(self) -> None:
        """Take the group away; its processes must have ended."""
        give_up = time.monotonic() + _GIVE_UP_S
        while self._folder.exists() and time.monotonic() < give_up:
            with suppress(OSError):  # the kernel lets go of the last process a little later
                self._folder.rmdir()
                return
            time.sleep(0.01)
