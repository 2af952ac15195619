"""Speeds are judged by their multiple of the calibration kernel."""

from dataclasses import replace

import pytest

from tools.benchmark.calibration_kernel import REFERENCE_S
from tools.benchmark.figure import Figure

RATE = Figure("bench", 50.0, "x real time", 100.0, at_least=True, speed=True)
COST = Figure("step", 1.0, "ms", 0.5, speed=True)


@pytest.mark.parametrize("figure", [RATE, COST])
def test_half_as_fast_is_enough_on_a_core_half_as_fast(figure):
    assert not replace(figure, kernel_s=REFERENCE_S).kept
    assert not replace(figure, kernel_s=1.9 * REFERENCE_S).kept
    assert replace(figure, kernel_s=2.0 * REFERENCE_S).kept


def test_the_multiple_of_a_rate_is_work_in_one_kernel_and_of_a_cost_its_kernels():
    assert replace(RATE, kernel_s=0.04).multiple == pytest.approx(2.0)
    assert replace(COST, kernel_s=0.04).multiple == pytest.approx(0.025)
    assert replace(COST, kernel_s=0.04).cells()[2] == "0.025"


def test_only_speeds_are_set_beside_the_kernel():
    plain = Figure("contacts", 0.0, "", 0.0)
    assert plain.beside_kernel() is plain
    assert plain.kept
    assert RATE.beside_kernel().kernel_s > 0.0
