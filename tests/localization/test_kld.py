"""KLD sample sizes against Fox's formula, and the bins they count."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import chi2

from localization.kld import SampleLimits, bin_keys, needed_samples, sample_size
from localization.settings import LocalizationSettings


@pytest.mark.parametrize("bins", [2, 5, 20, 100, 1000])
def test_sample_size_is_the_chi_square_quantile(bins: int) -> None:
    """Eq. 12: n = chi2_{k-1, 1-delta} / (2 error); the code has its Wilson-Hilferty form."""
    exact = chi2.ppf(0.99, bins - 1) / (2 * 0.05)
    assert sample_size(bins, 0.05, 2.326) == pytest.approx(exact, rel=0.05 if bins < 5 else 0.01)


def test_sample_size_of_a_known_example() -> None:
    """k = 100, error 0.05, delta 0.01: 99/0.1 (1 - 2/891 + sqrt(2/891) 2.326)^3 = 1347."""
    assert sample_size(100, 0.05, 2.326) == 1347


def test_one_bin_needs_one_sample() -> None:
    assert sample_size(1, 0.05, 2.33) == 1
    assert sample_size(0, 0.05, 2.33) == 1


def test_keys_are_shared_within_a_bin_only() -> None:
    particles = np.array(
        [
            [0.01, 0.01, 0.01],
            [0.09, 0.09, 0.02],
            [-0.01, 0.01, 0.01],
            [0.01, 0.11, 0.01],
            [0.01, 0.01, 0.2],
            [123.4, -567.8, 3.0],
        ]
    )
    keys = bin_keys(particles, 0.1, math.radians(5))
    assert keys[0] == keys[1]
    assert len(np.unique(keys)) == 5


def test_headings_either_side_of_pi_share_a_bin() -> None:
    keys = bin_keys(np.array([[0, 0, math.pi], [0, 0, -math.pi]]), 0.1, math.radians(5))
    assert keys[0] == keys[1]


def test_bin_count_equals_that_of_a_plain_loop() -> None:
    rng = np.random.default_rng(5)
    particles = rng.normal(0, (0.3, 0.3, 0.2), (2000, 3))
    step = math.tau / round(math.tau / 0.087)
    plain = {
        (math.floor(x / 0.1), math.floor(y / 0.1), math.floor((theta % math.tau) / step))
        for x, y, theta in particles
    }
    assert np.unique(bin_keys(particles, 0.1, 0.087)).size == len(plain)


def test_number_follows_the_spread_between_the_limits() -> None:
    limits = SampleLimits(minimum=50, maximum=3000)
    rng = np.random.default_rng(6)
    cloud = rng.standard_normal((3000, 3))
    middle = (0.05, 0.05, 0.04)
    sizes = [needed_samples(middle + cloud * s, limits) for s in (1e-4, 0.03, 0.1, 5.0)]
    assert sizes[0] == 50
    assert sizes[0] < sizes[1] < sizes[2] < sizes[3] == 3000


def test_a_fixed_number_is_kept() -> None:
    assert needed_samples(np.zeros((9, 3)), SampleLimits(500, 5000, 777)) == 777


def test_minimum_above_maximum_raises() -> None:
    with pytest.raises(ValueError, match="min_particles"):
        LocalizationSettings(min_particles=600, max_particles=500)
