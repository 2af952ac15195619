"""A recording names what its last bits depend on."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from maps.map_folder import load_map_folder
from robot_agent.config import AgentConfig, find_map
from robot_agent.recording.arithmetic import arithmetic, processor
from robot_agent.recording.run_header import header_of_run, same_arithmetic

WITHOUT_FMA = "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F"
PROGRAM = "from robot_agent.recording.arithmetic import arithmetic; print(arithmetic())"


def told_by_a_process(program: str = PROGRAM, **environment: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.strip()


def test_loops_kernels_and_c_library_are_named() -> None:
    words = arithmetic()
    assert words.startswith("numpy ")
    assert ", OpenBLAS " in words
    assert "unknown" not in words
    assert os.confstr("CS_GNU_LIBC_VERSION") in words


def test_every_process_of_this_computer_tells_the_same() -> None:
    assert told_by_a_process() == arithmetic()


@pytest.mark.skipif("fma" not in Path("/proc/cpuinfo").read_text(), reason="has no FMA to turn off")
def test_another_c_library_or_its_other_functions_are_told() -> None:
    """glibc takes other functions where the processor has no fused multiply-add."""
    without = told_by_a_process(GLIBC_TUNABLES=WITHOUT_FMA)
    assert without.rpartition(", ")[0] == arithmetic().rpartition(", ")[0]
    assert without != arithmetic()


def test_header_tells_computer_and_arithmetic() -> None:
    folder = load_map_folder(find_map("paper_lab", Path()))
    header = header_of_run(AgentConfig(), folder, source="live", start_wall_ns=0)
    assert header.processor == processor()
    assert same_arithmetic(header)
    assert same_arithmetic(replace(header, processor="another that rounds alike"))
    assert not same_arithmetic(replace(header, arithmetic="numpy SSE, OpenBLAS X, musl"))
    assert not same_arithmetic(replace(header, arithmetic=""))
    assert not same_arithmetic(replace(header, versions="python 3.9.2 x86_64"))
