"""numpy and BLAS compute alike on every processor of a kind."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys

import numpy as np
import pytest
from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__

PROGRAM = """
from tools.cli import main
import sys, warnings
warnings.simplefilter("ignore")
sys.exit(main(sys.argv[1:]))
"""
QEMU = shutil.which("qemu-x86_64")


def test_numpy_uses_no_loops_chosen_by_the_processor() -> None:
    assert not [name for name in __cpu_dispatch__ if __cpu_features__.get(name)]


def test_the_environment_does_not_change_the_choice() -> None:
    program = (
        "from tools.fixed_arithmetic import fix_arithmetic\n"
        "fix_arithmetic()\n"
        "import numpy as np\n"
        "x = np.linspace(0.1, 30.0, 1000, dtype=np.float32)\n"
        "print(np.sin(x).sum(), (x[:, None] * np.exp(-x)).T @ x)\n"
    )
    outputs = {
        subprocess.run(
            [sys.executable, "-W", "error", "-c", program],
            env={**os.environ, **chosen},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for chosen in (
            {},
            {"OPENBLAS_CORETYPE": "Haswell"},
            {"NPY_DISABLE_CPU_FEATURES": "AVX2", "OPENBLAS_CORETYPE": "Nehalem"},
        )
    }
    assert len(outputs) == 1


@pytest.mark.long
@pytest.mark.skipif(QEMU is None, reason="needs qemu-x86_64 of Debian's qemu-user")
@pytest.mark.skipif(platform.machine() != "x86_64", reason="emulates this Python's machine")
@pytest.mark.skipif(np.__version__ >= "2.4", reason="is not the pinned numpy")
def test_a_robot_patrols_on_a_core_2() -> None:
    """The oldest processor of the 64-bit boards that replace a Pioneer's computer."""
    assert QEMU is not None
    bench = ("bench", "--robots", "1", "--duration", "10")
    done = subprocess.run(
        [QEMU, "-cpu", "core2duo", sys.executable, "-c", PROGRAM, *bench],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
