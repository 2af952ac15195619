"""Debian packages that the trial needs on this machine."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Callable

from tools.field.trial_error import TrialError

PACKAGE_OF = {
    "qemu-system-x86_64": "qemu-system-x86",
    "qemu-img": "qemu-utils",
    "mmdebstrap": "mmdebstrap",
    "mke2fs": "e2fsprogs",
    "debugfs": "e2fsprogs",
    "setpriv": "util-linux",
    "faketime": "faketime",
}
"""Debian's package of each program."""


def missing_packages() -> list[str]:
    """Return the packages whose programs are not here, in order of name."""
    path = with_sbin()["PATH"]
    absent = {PACKAGE_OF[name] for name in PACKAGE_OF if shutil.which(name, path=path) is None}
    return sorted(absent)


def with_sbin() -> dict[str, str]:
    """Return this environment; its path has mke2fs and debugfs, as not every user's has."""
    return {**os.environ, "PATH": f"{os.environ.get('PATH', '')}:/usr/sbin:/sbin"}


def install_missing(report: Callable[[str], None]) -> None:
    """Install the missing packages as root; else raise TrialError with the line to run."""
    packages = missing_packages()
    if not packages:
        return
    command = ["apt-get", "install", "-y", "-q", "--no-install-recommends", *packages]
    if os.geteuid() != 0:
        raise TrialError(f"programs are missing: run `sudo {' '.join(command)}`")
    report(f"installing {', '.join(packages)}")
    for step in (["apt-get", "update", "-q"], command):
        done = subprocess.run(step, capture_output=True, text=True, check=False, timeout=600)
    if done.returncode:
        raise TrialError(f"{' '.join(command)}: {done.stderr.strip()[-300:]}")
