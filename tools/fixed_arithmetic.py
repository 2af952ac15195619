"""Makes numpy and BLAS compute the same bits on every processor of a kind.

numpy and OpenBLAS choose their loops by the processor's features, and each choice rounds sums and
functions differently. Replays, and studies of one seed, shall not depend on the computer, so the
choice is fixed to what every processor of the kind has. It costs nothing that can be measured:
``tools/replay/README.md``. The C library's functions are still chosen by processor and version.
"""

from __future__ import annotations

import os
import platform
from importlib.metadata import version

_FEATURES = {"x86_64": "SSE3", "aarch64": "ASIMD"}
"""A feature that numpy's loops need at least: naming it alone turns all others off."""
_FEATURES_X86_64_SINCE_2_4 = "X86_V2"
"""The same for numpy 2.4 and later, which counts features in levels."""
_KERNELS = {"x86_64": "Prescott", "aarch64": "ARMV8"}
"""OpenBLAS's oldest kernels of each kind of 64-bit processor."""


def fix_arithmetic() -> None:
    """Fix numpy's and OpenBLAS's choice, in this process and those it starts.

    Overrides the environment. Has no effect in a process that has imported numpy before, and none
    on other machines than x86-64 and arm64.
    """
    # Matrices are small: more BLAS threads cost time, and make sums depend on the machine.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    machine = platform.machine()
    if machine not in _KERNELS:
        return
    levels = machine == "x86_64" and needs_x86_64_v2(version("numpy"))
    features = _FEATURES_X86_64_SINCE_2_4 if levels else _FEATURES[machine]
    os.environ.pop("NPY_DISABLE_CPU_FEATURES", None)  # numpy refuses to have both
    os.environ["NPY_ENABLE_CPU_FEATURES"] = features
    os.environ["OPENBLAS_CORETYPE"] = _KERNELS[machine]


def needs_x86_64_v2(numpy_version: str) -> bool:
    """Whether the wheels of a numpy, e.g. "2.3.5", need x86-64-v2: SSE4.2 and more."""
    major, minor = (int(word) for word in numpy_version.split(".")[:2])
    return (major, minor) >= (2, 4)
