"""What the campaign lets hang, and how it sees whether the service's watchdog was fed."""

from __future__ import annotations

import os
import socket
import threading
from contextlib import closing
from pathlib import Path

import pytest

from tools.campaign.fault import Fault
from tools.campaign.fault_list import chosen_faults
from tools.campaign.fault_table import run_fault
from tools.campaign.journal_pipe import JournalPipe
from tools.campaign.service_watch import ServiceWatch


def test_longest_hunger_is_between_two_meals_or_at_an_end(tmp_path: Path) -> None:
    with (
        closing(ServiceWatch(tmp_path)) as service,
        socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as agent,
    ):
        for t in (1.0, 2.0, 4.5):
            agent.sendto(b"WATCHDOG=1", service.environment["NOTIFY_SOCKET"])
            service.step(t)
        agent.sendto(b"STATUS=x", service.environment["NOTIFY_SOCKET"])
        service.step(5.0)
        assert service.longest_hunger(0.5, 5.0) == pytest.approx(2.5)
        assert service.longest_hunger(0.5, 9.0) == pytest.approx(4.5)


def test_journal_that_hangs_takes_the_line_when_it_goes_on(tmp_path: Path) -> None:
    log = tmp_path / "log"
    journal = JournalPipe(log)
    os.write(journal.end, b"first\n")
    journal.hang()
    line = threading.Thread(target=os.write, args=(journal.end, b"second\n"))
    line.start()
    line.join(0.2)
    assert line.is_alive()
    journal.go_on()
    line.join(5.0)
    assert not line.is_alive()
    journal.close()
    assert log.read_text().replace("\0", "") == "first\nsecond\n"


@pytest.mark.long
@pytest.mark.parametrize(
    "fault", chosen_faults(["disk-hangs", "pose-file-hangs", "journal-hangs"]), ids=lambda f: f.name
)
def test_robot_patrols_on_and_says_what_hangs(fault: Fault, tmp_path: Path) -> None:
    reaction = run_fault(fault, tmp_path)
    if reaction.skipped:
        pytest.skip(reaction.skipped)
    assert reaction.complaints == []
    assert reaction.contacts == 0
