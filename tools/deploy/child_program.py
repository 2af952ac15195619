"""Python programs of ours as processes, which run this very code wherever they are started.

``python -m tools.cli`` takes a folder named ``tools`` in the working directory for ours.
"""

from __future__ import annotations

import os
import sys
import sysconfig
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
"""The folder that our packages are in."""


def program(module: str, *arguments: str) -> list[str]:
    """Return the command that runs a module of ours; give it ``environment`` too."""
    return [sys.executable, "-P", "-m", module, *arguments]


def environment() -> dict[str, str]:
    """Return this process's environment in which modules of ours are found, before any others.

    Where they are installed that is so anyway; the installed ones must not come before the
    standard library.
    """
    inherited = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    own = [] if Path(sysconfig.get_path("purelib")).resolve() == ROOT else [str(ROOT)]
    paths = dict.fromkeys([*own, *filter(None, inherited)])
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
