from __future__ import annotations

import pytest

from drivers.lms200.errors import ErrorEntry, Severity
from drivers.lms200.health import LaserHealth, health_of, status_byte

NOW, PAST = {"present": True}, {"present": False}


@pytest.mark.parametrize(
    ("status", "level", "pollution", "implausible"),
    [
        (0x10, Severity.OK, False, False),
        (0x11, Severity.INFO, False, False),
        (0x92, Severity.WARNING, True, False),
        (0x53, Severity.ERROR, False, True),
        (0xD4, Severity.FATAL, True, True),
        (0x17, Severity.FATAL, False, False),
    ],
)
def test_status_byte_is_read_and_written(
    status: int, level: Severity, pollution: bool, implausible: bool
) -> None:
    health = health_of(status, (), defective=False)
    assert (health.level, health.pollution, health.implausible) == (level, pollution, implausible)
    if status & 7 <= Severity.FATAL:
        assert status_byte(health, 0x10) == status


@pytest.mark.parametrize(
    ("health", "ok"),
    [
        (LaserHealth(Severity.OK), True),
        (LaserHealth(Severity.INFO), True),
        (LaserHealth(Severity.WARNING), False),
        (LaserHealth(Severity.OK, pollution=True), False),
        (LaserHealth(Severity.OK, implausible=True), False),
        (LaserHealth(Severity.OK, defective=True), False),
        (LaserHealth(Severity.OK, errors=(ErrorEntry(Severity.FATAL, 57, **PAST),)), True),
        (LaserHealth(Severity.OK, errors=(ErrorEntry(Severity.INFO, 45, **NOW),)), True),
        (LaserHealth(Severity.OK, errors=(ErrorEntry(Severity.WARNING, 17, **NOW),)), False),
    ],
)
def test_ok_requires_no_present_error_and_no_flag(health: LaserHealth, ok: bool) -> None:
    assert health.ok is ok
    assert (health.text == "ok") is ok


def test_text_contains_every_finding_with_remedy() -> None:
    errors = (ErrorEntry(2, 18, present=True), ErrorEntry(4, 57, present=False))
    health = LaserHealth(Severity.ERROR, True, True, True, errors)
    assert health.present_errors == errors[:1]
    for words in ("warning 18", "wipe it", "dazzled", "switch it off and on"):
        assert words in health.text
    assert "57" not in health.text
    assert LaserHealth(Severity.WARNING).text == "status warning"
