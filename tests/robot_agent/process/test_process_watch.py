from __future__ import annotations

import pytest

from robot_agent.process.process_watch import PERIOD_S, ProcessWatch


def test_lateness_pauses_and_misses_are_of_the_last_period() -> None:
    watch = ProcessWatch("anna", 0)
    assert not watch.handled(0.1, 0.101)
    assert not watch.handled(0.2, 0.26)
    assert watch.handled(PERIOD_S, PERIOD_S + 0.002)
    report = watch.report(lost=0, trouble="", dropped=4)
    assert (report.events, report.deadline_misses, report.telemetry_dropped) == (3, 1, 4)
    assert report.lateness_median == pytest.approx(0.002)
    assert report.lateness_max == pytest.approx(0.06)
    assert report.longest_pause == pytest.approx(PERIOD_S + 0.002 - 0.26)
    assert report.memory_mb > 1.0
    watch.handled(2.0, 2.001)
    assert watch.report(0, "", 0).events == 1
