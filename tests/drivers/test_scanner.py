"""What is the same for scanners of any kind."""

from __future__ import annotations

from itertools import pairwise

import pytest

from drivers.lms1xx.session import Lms1xxSession, SessionState
from drivers.lms1xx.settings import LaserSettings as Lms1xxSettings
from drivers.lms200.session import Lms200Session
from drivers.lms200.session import SessionState as Lms200State
from drivers.lms200.settings import LaserSettings as Lms200Settings
from drivers.scanner import DEFAULT_KIND, STREAMING, kind_of, look_period, scanner_session


def test_each_kind_has_its_session() -> None:
    assert kind_of(Lms200Settings()) == DEFAULT_KIND
    assert kind_of(Lms1xxSettings()) == "lms1xx"
    assert isinstance(scanner_session(Lms200Settings()), Lms200Session)
    assert isinstance(scanner_session(Lms1xxSettings()), Lms1xxSession)


def test_the_state_in_which_scans_come_is_called_the_same() -> None:
    assert SessionState.STREAMING == Lms200State.STREAMING == STREAMING


@pytest.mark.parametrize(
    ("frequency", "scans"), [(15.0, 1), (25.0, 2), (35.0, 3), (50.0, 5), (75.0, 7), (100.0, 10)]
)
def test_one_scan_a_decision_is_looked_at(frequency: float, scans: int) -> None:
    period = 1.0 / frequency
    every = look_period(Lms1xxSettings(frequency=frequency))
    taken, due = [], -1.0
    for number in range(100):
        if number * period >= due:
            taken.append(number)
            due = number * period + every
    assert {b - a for a, b in pairwise(taken)} == {scans}


@pytest.mark.parametrize("baud", [38400, 500000])
def test_every_scan_of_an_lms_200_is_looked_at(baud: int) -> None:
    assert look_period(Lms200Settings(baud=baud)) == 0.0
