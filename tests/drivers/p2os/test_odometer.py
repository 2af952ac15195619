from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.p2os.odometer import Odometer, counter_step


@given(
    st.integers(-(10**6), 10**6),
    st.integers(-2048, 2047),
    st.sampled_from([12, 15, 16]),
)
def test_step_is_right_for_any_counter_width(old: int, step: int, bits: int) -> None:
    mask = (1 << bits) - 1
    assert counter_step((old + step) & mask, old & mask) == step


def test_first_counters_only_set_the_reference() -> None:
    odometer = Odometer()
    odometer.update(32000, 5, 0, 0.001)
    assert (odometer.x, odometer.y, odometer.theta) == (0.0, 0.0, 0.0)
    odometer.update((32000 + 1000) & 0x7FFF, 5, 0, 0.001)
    assert (odometer.x, odometer.y) == pytest.approx((1.0, 0.0))


def test_heading_accumulates_over_turns() -> None:
    odometer = Odometer()
    for turn in range(41):
        odometer.update(0, 0, (turn * 1024 + 2048) % 4096 - 2048, 0.001)
    assert odometer.theta == pytest.approx(10 * math.tau)


def test_pose_is_continuous_over_a_new_reference() -> None:
    odometer = Odometer()
    odometer.update(0, 0, 0, 0.001)
    odometer.update(1000, 0, 1024, 0.001)
    odometer.forget_reference()
    odometer.update(500, 500, 0, 0.001)
    assert (odometer.x, odometer.y, odometer.theta) == pytest.approx((1.0, 0.0, math.pi / 2))
    odometer.update(700, 600, 0, 0.001)
    assert (odometer.x, odometer.y) == pytest.approx((0.9, 0.2))
