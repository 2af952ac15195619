from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from drivers.lms200.emulator.mirror import EmulatedMirror, Sweep, next_multiple
from drivers.lms200.measurement import TURN
from drivers.lms200.telegrams import VARIANTS, Variant


class Clock:
    """A scan source whose ranges are the time of the call."""

    def __init__(self) -> None:
        self.asked: list[float] = []

    def __call__(self, t: float, n: int, increment: float) -> NDArray[np.float64]:
        self.asked.append(t)
        self.shape = (n, increment)
        return np.full(n, t)


def sweeps(mirror: EmulatedMirror, variant: Variant, end: float, wire: float = 0.0) -> list[Sweep]:
    found = []
    while sweep := mirror.measure(variant, wire, end):
        found.append(sweep)
    return found


def test_idle_mirror_measures_nothing() -> None:
    mirror = EmulatedMirror(Clock())
    assert mirror.measure(VARIANTS[0], 0.0, 10.0) is None
    mirror.start(0.0)
    mirror.stop()
    assert mirror.measure(VARIANTS[0], 0.0, 10.0) is None


@pytest.mark.parametrize("variant", VARIANTS)
def test_whole_sweeps_are_consecutive_with_each_turn_at_its_own_time(variant: Variant) -> None:
    clock = Clock()
    mirror = EmulatedMirror(clock)
    mirror.start(0.0)
    turns = variant.mirror_turns
    found = sweeps(mirror, variant, 10.5 * turns * TURN)
    assert [sweep.end for sweep in found[:10]] == pytest.approx(
        [(k + 1) * turns * TURN for k in range(10)]
    )
    assert clock.shape == (variant.count, math.radians(variant.resolution_cdeg / 100))
    for number, sweep in enumerate(found):
        assert sweep.quarter is None
        for turn in range(turns):
            middle = (number * turns + turn + 0.5) * TURN
            assert sweep.ranges[turn::turns] == pytest.approx(middle)
    assert clock.asked == sorted(clock.asked)


def test_sweep_that_would_end_while_the_wire_is_busy_is_not_measured() -> None:
    mirror = EmulatedMirror(Clock())
    mirror.start(0.0)
    sweep = mirror.measure(Variant(180, 50), 0.1, 1.0)
    assert sweep is not None
    assert sweep.end == pytest.approx(next_multiple(0.1, 2 * TURN))


@pytest.mark.parametrize("variant", [Variant(180, 50), Variant(100, 25)])
def test_partial_scans_cycle_through_the_offsets(variant: Variant) -> None:
    mirror = EmulatedMirror(Clock())
    mirror.start(0.0, partial=True)
    found = sweeps(mirror, variant, 8.6 * TURN)
    turns = variant.mirror_turns
    quarters = [turn * variant.resolution_cdeg // 25 for turn in range(turns)]
    assert [sweep.quarter for sweep in found[: 2 * turns]] == quarters * 2
    assert [sweep.end for sweep in found[:4]] == pytest.approx([TURN * k for k in range(1, 5)])
    sizes = [sweep.ranges.size for sweep in found[:turns]]
    assert sizes == [181] + [180] * (turns - 1)


def test_next_multiple_is_the_first_at_or_after_t() -> None:
    assert next_multiple(0.0, 0.5) == 0.0
    assert next_multiple(0.4, 0.5) == 0.5
    assert next_multiple(1.5 + 1e-9, 0.5) == 1.5


@pytest.mark.parametrize("partial", [False, True])
def test_reflectors_are_those_of_each_beams_own_turn(*, partial: bool) -> None:
    clock = Clock()

    def reflectors() -> NDArray[np.bool_]:
        return np.full(clock.shape[0], len(clock.asked) % 2 == 1)

    mirror = EmulatedMirror(clock, reflectors)
    mirror.start(0.0, partial=partial)
    found = sweeps(mirror, Variant(180, 50), 4.6 * TURN)
    first, second = found[:2]
    assert first.reflectors is not None
    assert second.reflectors is not None
    assert len(first.reflectors) == len(first.ranges)
    if partial:
        assert first.reflectors.all()
        assert not second.reflectors.any()
    else:
        assert first.reflectors[::2].all()
        assert not first.reflectors[1::2].any()
