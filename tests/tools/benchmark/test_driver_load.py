from __future__ import annotations

import pytest

from tools.benchmark.driver_load import FULL_RATE, driver_load


@pytest.mark.parametrize("kind", FULL_RATE)
def test_drivers_at_full_rate_return_load_and_both_rates(kind: str) -> None:
    share, scans, reports = driver_load(1.0, FULL_RATE[kind])
    assert scans > 0
    assert reports > 0
    assert share > 0
