"""What is trusted for how long: one table for gate, alarms and README."""

from pathlib import Path

from robot_agent.motion.gate_settings import GateSettings
from robot_agent.motion.trust import BASE, LASER, TRUSTED, TrustWatch, markdown

README = Path(__file__).parents[3] / "README.md"


def test_readme_has_the_table():
    assert markdown() in README.read_text()


def test_the_gate_has_its_limits_from_the_table():
    settings = GateSettings()
    assert settings.max_base_age == BASE.max_age
    assert settings.max_scan_age == LASER.max_age


def test_every_stream_may_miss_one_of_its_own():
    for stream in TRUSTED:
        assert stream.max_age >= 1.0 / stream.rate


def test_a_stream_is_missed_once_and_comes_back_once():
    watch = TrustWatch()
    assert watch.changes(0.0) == []
    watch.well(BASE, 1.0)
    assert watch.changes(0.99 + BASE.max_age) == []
    assert watch.changes(1.01 + BASE.max_age) == [(BASE, False)]
    assert watch.changes(2.0) == []
    watch.well(BASE, 2.1)
    assert watch.changes(2.1) == [(BASE, True)]
    assert watch.changes(2.2) == []
