from __future__ import annotations

from tools.benchmark.driver_load import driver_load


def test_both_drivers_reach_their_streams_and_their_threads_are_timed() -> None:
    share, scans, reports = driver_load(1.0)
    assert scans > 0
    assert reports > 0
    assert share > 0
