"""Commands and environment to run modules of this product as child processes, from any directory.

Plain ``python -m tools.cli`` would import a folder named ``tools`` in the working directory.
"""

from __future__ import annotations

import os
import sys
import sysconfig
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
"""The folder that holds this product's packages."""


def program(module: str, *arguments: str) -> list[str]:
    """Return the command that runs a module of this product; needs ``environment()`` too."""
    return [sys.executable, "-P", "-m", module, *arguments]


def environment() -> dict[str, str]:
    """Return this process's environment with ``PYTHONPATH`` extended to find these packages first.

    Installed packages need no such entry, and site-packages must not precede the standard library.
    """
    inherited = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    own = [] if Path(sysconfig.get_path("purelib")).resolve() == ROOT else [str(ROOT)]
    paths = dict.fromkeys([*own, *filter(None, inherited)])
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
