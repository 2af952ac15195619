"""Low-variance resampling: unbiased, and every count within one of its expectation."""

from __future__ import annotations

import numpy as np
import pytest

from localization.resampling import draw_low_variance, effective_sample_size

WEIGHTS = np.array([0.05, 0.3, 0.0, 0.21, 0.44])


def test_counts_are_expectations_rounded_up_or_down() -> None:
    rng = np.random.default_rng(1)
    for count in (1, 7, 100):
        counts = np.bincount(draw_low_variance(WEIGHTS, count, rng), minlength=5)
        assert counts.sum() == count
        assert np.all(np.abs(counts - count * WEIGHTS) < 1.0)
        assert counts[2] == 0


def test_drawn_counts_are_unbiased() -> None:
    rng = np.random.default_rng(2)
    total = sum(np.bincount(draw_low_variance(WEIGHTS, 8, rng), minlength=5) for _ in range(4000))
    assert total / 32000 == pytest.approx(WEIGHTS, abs=0.005)


def test_weights_short_of_one_by_rounding_stay_in_range() -> None:
    short = np.full(3, 1 / 3 - 1e-3)
    rng = np.random.default_rng(3)
    assert max(draw_low_variance(short, 1000, rng)) == 2


def test_effective_sample_size_of_equal_and_single_weights() -> None:
    assert effective_sample_size(np.full(40, 1 / 40)) == pytest.approx(40)
    assert effective_sample_size(np.array([0.0, 1.0, 0.0])) == 1.0
    assert effective_sample_size(np.array([0.5, 0.5, 0.0])) == pytest.approx(2.0)
