from __future__ import annotations

import pytest

from drivers.lms1xx.framing import Dialect, Telegram
from drivers.lms1xx.health import LaserHealth, health_of, status_of
from drivers.lms1xx.health_watch import PAUSE, HealthWatch
from drivers.lms1xx.telegrams import Contamination


def state(number: int) -> Telegram:
    return Telegram(Dialect.B, b"sRA LCMstate " + bytes((number,)))


@pytest.mark.parametrize(
    ("health", "words"),
    [
        (LaserHealth(), "ok"),
        (LaserHealth(error=True), "laser reports an error"),
        (LaserHealth(contamination=Contamination.WARNING), "polluted (warning)"),
        (LaserHealth(contamination=Contamination.ERROR), "polluted (error)"),
        (LaserHealth(contamination=Contamination.DEFECT), "cannot measure how dirty"),
    ],
)
def test_each_condition_has_words(health: LaserHealth, words: str) -> None:
    assert words in health.text
    assert health.ok == (words == "ok")
    assert health.pollution == ("polluted" in words)


@pytest.mark.parametrize("status", [0, 1, 2, 4, 5])
def test_the_status_of_a_scan_comes_back(status: int) -> None:
    assert status_of(health_of(status)) == status


def test_the_worse_of_scan_and_question_counts() -> None:
    assert health_of(0x02, Contamination.ERROR).contamination is Contamination.ERROR
    assert health_of(0x04, Contamination.WARNING).contamination is Contamination.ERROR


def test_a_changed_status_is_asked_about_once_in_a_while() -> None:
    watch = HealthWatch()
    assert watch.health is None
    watch.on_scan_status(0)
    assert not watch.question_due(1.0)
    watch.on_scan_status(2)
    assert watch.question_due(1.0)
    assert not watch.question_due(1.1)
    watch.on_scan_status(0)
    assert not watch.question_due(1.2)
    assert watch.question_due(1.0 + PAUSE)


def test_states_that_nobody_knows_are_ignored() -> None:
    watch = HealthWatch()
    watch.on_telegram(state(9))
    assert watch.health is None
    watch.on_telegram(state(3))
    assert watch.health is not None
    assert watch.health.contamination is Contamination.DEFECT
