"""The onboard process as a service: notifications to its manager, pauses after failed starts."""

from __future__ import annotations

import signal
import socket
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tools.deploy.child_program import environment, program

PATIENCE_S = 30.0


@contextmanager
def service(folder: Path) -> Iterator[tuple[subprocess.Popen[str], socket.socket]]:
    """An agent started as a service, with the socket that gets its notifications."""
    robot = folder / "robot1.toml"
    robot.write_text('[base]\nurl = "/dev/none-such"\n[laser]\nurl = "/dev/none-such"\n')
    (folder / "run").mkdir(exist_ok=True)
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        manager.bind(str(folder / "notify"))
        manager.settimeout(PATIENCE_S)
        with subprocess.Popen(
            program("tools.cli", "agent", str(robot)),
            env={
                **environment(),
                "NOTIFY_SOCKET": str(folder / "notify"),
                "WATCHDOG_USEC": "3000000",
                "RUNTIME_DIRECTORY": str(folder / "run"),
            },
            stderr=subprocess.PIPE,
            text=True,
        ) as agent:
            try:
                yield agent, manager
            finally:
                agent.kill()
                assert agent.stderr is not None
                agent.stderr.read()
    (folder / "notify").unlink()


def test_service_is_ready_before_the_agent_runs_and_its_good_end_forgets_failed_starts(
    tmp_path: Path,
) -> None:
    with service(tmp_path) as (agent, manager):
        assert manager.recv(1000) == b"READY=1\nSTATUS=starting\nWATCHDOG_USEC=180000000"
        assert (tmp_path / "run" / "starts").is_file()
        running = b"STATUS=patrolling agent started\nWATCHDOG_USEC=3000000\nWATCHDOG=1"
        assert manager.recv(1000) == running
        assert manager.recv(1000) == b"WATCHDOG=1"
        agent.send_signal(signal.SIGTERM)
        assert agent.wait(PATIENCE_S) == 0
    assert not (tmp_path / "run" / "starts").exists()


def test_third_start_after_failed_ones_waits_and_says_so(tmp_path: Path) -> None:
    for words in ("starting", "starting", "failed 2 times within a minute of its start, waits 2 s"):
        with service(tmp_path) as (agent, manager):
            assert f"STATUS={words}\n" in manager.recv(1000).decode()
            agent.kill()  # at once: it has not run for a minute
            assert agent.wait(PATIENCE_S) == -signal.SIGKILL
