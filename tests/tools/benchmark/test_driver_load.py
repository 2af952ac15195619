from __future__ import annotations

from tools.benchmark.driver_load import driver_load


def test_drivers_at_full_rate_return_load_and_both_rates() -> None:
    share, scans, reports = driver_load(1.0)
    assert scans > 0
    assert reports > 0
    assert share > 0
