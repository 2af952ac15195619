"""Processors that can run numpy, and those that are told what to do."""

from __future__ import annotations

import pytest

from tools.computer_check import unfit_computer, unfit_processor

CORE_2 = "fpu sse sse2 ht syscall nx lm constant_tsc pni monitor ds_cpl vmx est tm2 ssse3 cx16 xtpr"
NEHALEM = f"{CORE_2} sse4_1 sse4_2 popcnt"
FIRST_OPTERON = "fpu sse sse2 syscall nx lm"


def cpuinfo(flags: str) -> str:
    one = f"processor\t: 0\nmodel name\t: Some CPU: 1.6 GHz\nflags\t\t: {flags}\n\n"
    return one + one


def test_this_computer_is_fit() -> None:
    assert unfit_computer() is None


@pytest.mark.parametrize(
    ("flags", "numpy_version"),
    [(CORE_2, "2.3.5"), (NEHALEM, "2.3.5"), (NEHALEM, "2.4.0"), (NEHALEM, "3.0.0")],
)
def test_a_fit_processor_is_not_refused(flags: str, numpy_version: str) -> None:
    assert unfit_processor(cpuinfo(flags), numpy_version) is None


def test_a_core_2_with_a_newer_numpy_is_told_which_to_install() -> None:
    words = unfit_processor(cpuinfo(CORE_2), "2.4.6")
    assert words is not None
    assert "(Some CPU: 1.6 GHz) lacks popcnt, sse4_1, sse4_2, which numpy 2.4.6 needs" in words
    assert "install the numpy of tools/constraints.txt" in words
    assert "\n" not in words


def test_a_processor_without_sse3_is_told_which_computer_is_needed() -> None:
    for numpy_version in ("2.3.5", "2.4.6"):
        words = unfit_processor(cpuinfo(FIRST_OPTERON), numpy_version)
        assert words is not None
        assert words.endswith("a 64-bit computer of 2005 or later is needed")


def test_a_file_that_names_no_flags_is_no_reason_to_refuse() -> None:
    assert unfit_processor("", "2.4.6") is None
    assert unfit_processor("processor : 0\n", "2.4.6") is None
