"""Notices begin once, name a remedy, and are taken back."""

from __future__ import annotations

from robot_agent.messages.log_level import LogLevel
from robot_agent.report.notices import scale_notice


def test_ways_of_another_scale_are_told_once_with_share_and_remedy() -> None:
    notice = scale_notice(5.0, 0.104, warned=False)
    assert notice is not None
    assert notice.level is LogLevel.WARNING
    assert "10% more way than the wheels count" in notice.words
    assert "patrol calibrate odometry" in notice.words
    assert scale_notice(5.1, 0.104, warned=True) is None
    less = scale_notice(5.0, -0.08, warned=False)
    assert less is not None
    assert "8% less way" in less.words


def test_ways_within_the_tolerance_are_told_only_to_take_a_warning_back() -> None:
    assert scale_notice(5.0, None, warned=False) is None
    well = scale_notice(5.0, None, warned=True)
    assert well is not None
    assert well.level is LogLevel.INFO
