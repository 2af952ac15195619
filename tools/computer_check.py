"""Is this computer's processor able to run the installed numpy?

One that is not would end with an illegal instruction when numpy is imported, and no word.
"""

from __future__ import annotations

import platform
from importlib.metadata import version
from pathlib import Path

from tools.fixed_arithmetic import needs_x86_64_v2

_CPUINFO = Path("/proc/cpuinfo")
_BASELINE = ("pni",)
"""SSE3: what the pinned wheels of numpy and OpenCV are compiled for. Names of /proc/cpuinfo."""
_X86_64_V2 = (*_BASELINE, "ssse3", "cx16", "popcnt", "sse4_1", "sse4_2")
"""What numpy's wheels are compiled for since 2.4."""


def unfit_computer() -> str | None:
    """Return why this computer cannot run the installed numpy, and what to do; None if it can."""
    if platform.machine() != "x86_64":
        return None
    try:
        cpuinfo = _CPUINFO.read_text()
    except OSError:
        return None
    return unfit_processor(cpuinfo, version("numpy"))


def unfit_processor(cpuinfo: str, numpy_version: str) -> str | None:
    """Return why an x86-64 processor cannot run a numpy, and what to do; None if it can.

    cpuinfo: text of /proc/cpuinfo, whose first processor is taken.
    """
    fields: dict[str, str] = {}
    for line in cpuinfo.partition("\n\n")[0].splitlines():
        name, _, value = line.partition(":")
        fields[name.strip()] = value.strip()
    needed = _X86_64_V2 if needs_x86_64_v2(numpy_version) else _BASELINE
    present = fields.get("flags", "").split()
    missing = [name for name in needed if name not in present]
    if not present or not missing:
        return None
    remedy = (
        "install the numpy of tools/constraints.txt, which needs SSE3 alone"
        if needed is _X86_64_V2 and all(name in present for name in _BASELINE)
        else "a 64-bit computer of 2005 or later is needed"
    )
    return (
        f"this processor ({fields.get('model name', 'no name')}) lacks {', '.join(missing)}, "
        f"which numpy {numpy_version} needs: {remedy}"
    )
