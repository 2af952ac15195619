from __future__ import annotations

from drivers.lms200 import telegrams
from drivers.lms200.errors import ErrorEntry, Severity, encode_errors
from drivers.lms200.framing import Telegram
from drivers.lms200.health_watch import PAUSE, STEP_LIMIT, HealthWatch
from drivers.lms200.telegrams import DeviceStatus, Variant

POLLUTED = 0x92


def errors(*entries: ErrorEntry, status: int = 0x10) -> Telegram:
    return Telegram(0x80, encode_errors(entries)[:-1] + bytes((status,)))


def device_status(*, defective: bool = False) -> Telegram:
    status = DeviceStatus("V02.10", 0x25, defective, 5, Variant(180, 100), 38400, 1)
    return Telegram(0x80, status.encode())


def set_up() -> HealthWatch:
    """Return a watch after the replies of a healthy laser's set-up and its first scan."""
    watch = HealthWatch()
    assert watch.health is None
    watch.on_telegram(device_status())
    watch.on_telegram(errors())
    watch.on_scan_status(0x10)
    assert watch.health is not None
    assert watch.health.ok
    return watch


def test_healthy_laser_is_not_queried() -> None:
    watch = set_up()
    for step in range(200):
        watch.on_scan_status(0x10)
        assert watch.next_command(0.1 * step) is None


def test_changed_status_byte_updates_health_and_starts_a_query() -> None:
    watch = set_up()
    watch.on_scan_status(POLLUTED)
    assert watch.health is not None
    assert watch.health.pollution
    assert watch.next_command(1.0) == telegrams.READ_ERRORS
    assert watch.next_command(1.1) is None
    watch.on_telegram(errors(ErrorEntry(Severity.WARNING, 17, present=True), status=POLLUTED))
    assert watch.health.text.startswith("warning 17")
    assert watch.next_command(1.2) == telegrams.READ_STATUS
    watch.on_telegram(device_status(defective=True))
    assert watch.health.defective
    assert watch.next_command(1.3) == telegrams.SELECT_CONTINUOUS
    assert watch.next_command(9.0) is None


def test_stream_that_resumes_by_itself_is_not_restarted() -> None:
    watch = set_up()
    watch.on_scan_status(POLLUTED)
    watch.next_command(1.0)
    watch.on_telegram(errors(status=POLLUTED))
    watch.next_command(1.1)
    watch.on_scan_status(POLLUTED)
    watch.on_telegram(device_status())
    assert watch.next_command(1.2 + STEP_LIMIT) is None


def test_unanswered_queries_time_out() -> None:
    watch = set_up()
    watch.on_scan_status(POLLUTED)
    asked = [
        (0.1 * step, command)
        for step in range(30)
        if (command := watch.next_command(0.1 * step)) is not None
    ]
    assert [command for _, command in asked] == [
        telegrams.READ_ERRORS,
        telegrams.READ_STATUS,
        telegrams.SELECT_CONTINUOUS,
    ]
    assert asked[-1][0] >= 2 * STEP_LIMIT


def test_flickering_status_is_queried_at_a_limited_rate() -> None:
    watch = set_up()
    questions = 0
    for step in range(600):
        watch.on_scan_status(POLLUTED if step % 2 else 0x10)
        questions += watch.next_command(0.1 * step) == telegrams.READ_ERRORS
    assert 2 <= questions <= 60.0 / PAUSE + 1


def test_restart_clears_pending_queries() -> None:
    watch = set_up()
    watch.on_scan_status(POLLUTED)
    watch.next_command(0.0)
    watch.restart()
    assert watch.next_command(9.0) is None
    watch.on_telegram(errors())
    watch.on_scan_status(0x10)
    assert watch.next_command(20.0) is None


def test_short_status_telegrams_and_other_replies_are_ignored() -> None:
    watch = HealthWatch()
    watch.on_telegram(Telegram(0x80, b"\xb1\x10"))
    watch.on_telegram(Telegram(0x80, b"\xa0\x00\x10"))
    assert watch.health is None
