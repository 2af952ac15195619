"""Notifications to the service manager, over a real socket."""

import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from robot_agent.process.service_notifier import ServiceNotifier


@pytest.fixture
def manager(tmp_path: Path) -> Iterator[socket.socket]:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listener:
        listener.bind(str(tmp_path / "notify"))
        listener.setblocking(False)
        yield listener


def heard(manager: socket.socket) -> list[str]:
    found = []
    while True:
        try:
            found.append(manager.recv(4096).decode())
        except BlockingIOError:
            return found


def test_is_ready_before_it_starts_and_only_then_under_the_watchdog(manager: socket.socket) -> None:
    notifier = ServiceNotifier({"NOTIFY_SOCKET": manager.getsockname(), "WATCHDOG_USEC": "3000000"})
    notifier.starting("waits 8 s")
    notifier.running()
    assert heard(manager) == [
        "READY=1\nSTATUS=waits 8 s\nWATCHDOG_USEC=180000000",
        "STATUS=patrolling agent started\nWATCHDOG_USEC=3000000\nWATCHDOG=1",
    ]


def test_without_a_watchdog_none_is_set(manager: socket.socket) -> None:
    notifier = ServiceNotifier({"NOTIFY_SOCKET": manager.getsockname()})
    notifier.starting()
    notifier.running()
    assert heard(manager) == ["READY=1\nSTATUS=starting", "STATUS=patrolling agent started"]


def test_sends_ready_watchdog_and_stopping(manager: socket.socket) -> None:
    notifier = ServiceNotifier({"NOTIFY_SOCKET": manager.getsockname(), "WATCHDOG_USEC": "3000000"})
    assert notifier.period == pytest.approx(1.0)
    notifier.starting()
    for step in range(61):
        notifier.alive(0.05 * step)
    notifier.stopping()
    messages = heard(manager)
    assert messages[0].startswith("READY=1")
    assert messages[1:-1] == ["WATCHDOG=1"] * 3, "three times in its patience, not 20 per second"
    assert messages[-1] == "STOPPING=1"


def test_abstract_socket_is_supported() -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listener:
        listener.bind("\0patrol-test-notify")
        ServiceNotifier({"NOTIFY_SOCKET": "@patrol-test-notify"}).starting()
        assert listener.recv(100).startswith(b"READY=1")


def test_without_a_manager_nothing_is_sent(tmp_path: Path) -> None:
    alone = ServiceNotifier({"WATCHDOG_USEC": "3000000"})
    assert alone.period is None
    alone.starting()
    alone.alive(100.0)
    ServiceNotifier({"NOTIFY_SOCKET": str(tmp_path / "gone")}).stopping()
