"""What the last bits of this process's numbers depend on: processor, loops, kernels, C library."""

from __future__ import annotations

import ctypes
import hashlib
import os
from functools import cache
from pathlib import Path

import numpy as np

_CPUINFO = Path("/proc/cpuinfo")
_LOADED = Path("/proc/self/maps")
_MODEL_NAMES = ("model name", "Model", "CPU part")
"""Lines of /proc/cpuinfo that name the processor, on x86-64 and on arm64 boards."""
_KERNEL_NAMES = (
    *("scipy_openblas_get_corename64_", "openblas_get_corename64_"),
    *("scipy_openblas_get_corename", "openblas_get_corename"),
)
"""OpenBLAS's function that names its kernels, in its various builds."""
_ARGUMENTS = (np.arange(10_000) + 0.5) * 0.00137
"""At which functions are tried. glibc's with and without fused multiply-add differ in the last bit
at one of about 2000 (measured)."""
_FUNCTIONS = (np.sin, np.cos, np.exp, np.log, np.arctan)
_FUNCTIONS_OF_TWO = (np.hypot, np.arctan2)


@cache
def processor() -> str:
    """Return the name of the processor; empty where the system does not tell."""
    try:
        lines = _CPUINFO.read_text().splitlines()
    except OSError:
        return ""
    named: dict[str, str] = {}
    for line in lines:
        name, _, value = line.partition(":")
        named[name.strip()] = value.strip()
    return next((named[name] for name in _MODEL_NAMES if name in named), "")


@cache
def arithmetic() -> str:
    """Return what decides how this process rounds; where it is equal, so are all results.

    numpy's loops (features of the processor), OpenBLAS's kernels, the C library, and a digest of
    the results of transcendental functions, as the C library has several of each.
    """
    libc = os.confstr("CS_GNU_LIBC_VERSION") or "another C library"
    return f"numpy {_loops()}, OpenBLAS {_kernels()}, {libc}, functions {_functions()}"


def _loops() -> str:
    """Return the features of the processor that numpy uses."""
    features = np.show_config(mode="dicts")["SIMD Extensions"]
    return "+".join((*features["baseline"], *features.get("found", ())))


def _kernels() -> str:
    """Return the name of the kernels of the OpenBLAS that numpy has loaded, or "unknown"."""
    if not _LOADED.exists():
        return "unknown"
    loaded = {line.split(maxsplit=5)[-1] for line in _LOADED.read_text().splitlines()}
    libraries = [path for path in loaded if "openblas" in path]
    # OpenCV's wheel brings another one, which has other names for its kernels.
    for path in sorted(libraries, key=lambda path: ("numpy" not in path, path)):
        library = ctypes.CDLL(path)
        for name in _KERNEL_NAMES:
            if hasattr(library, name):
                get_name = getattr(library, name)
                get_name.restype = ctypes.c_char_p
                return str(get_name().decode())
    return "unknown"


def _functions() -> str:
    """Return a short digest of the results of functions at fixed arguments."""
    digest = hashlib.sha256()
    for precision in (np.float32, np.float64):
        x = _ARGUMENTS.astype(precision)
        for of_one in _FUNCTIONS:
            digest.update(of_one(x).tobytes())
        for of_two in _FUNCTIONS_OF_TWO:
            digest.update(of_two(x, x[::-1]).tobytes())
    return digest.hexdigest()[:12]
