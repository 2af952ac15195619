"""Faults of a patrolling robot in real time: emulators on pseudo-terminals, the agent process.

Times depend on the machine and are checked by `patrol faults`; here only the reactions are checked.
"""

from __future__ import annotations

from pathlib import Path

from tools.campaign.fault_list import chosen_faults
from tools.campaign.fault_table import run_fault
from tools.campaign.reaction import Reaction


def take(name: str, folder: Path) -> Reaction:
    (fault,) = chosen_faults([name])
    return run_fault(fault, folder)


def test_base_stops_by_watchdog_when_its_cable_is_unplugged(tmp_path: Path) -> None:
    reaction = take("base-unplugged", tmp_path)
    assert reaction.ordered_by == "watchdog"
    assert reaction.detected_by == "event: base"
    assert reaction.detected is not None
    assert reaction.ordered is not None
    assert reaction.detected < reaction.ordered
    assert reaction.stopped is not None
    assert reaction.stopped > reaction.ordered
    assert reaction.first_order == "STOP"
    assert reaction.back is not None
    assert reaction.recovered is not None
    assert reaction.recovered > reaction.back
    assert reaction.contacts == 0


def test_agent_stops_when_the_scans_end(tmp_path: Path) -> None:
    reaction = take("laser-silent", tmp_path)
    assert reaction.ordered_by == "agent"
    assert reaction.stopped is not None
    assert reaction.back is not None
    assert reaction.recovered is not None
    assert reaction.contacts == 0


def test_patrol_goes_on_when_the_camera_thread_dies(tmp_path: Path) -> None:
    reaction = take("camera-thread", tmp_path)
    assert reaction.detected_by == "event: camera"
    assert reaction.recovered is not None
    assert reaction.contacts == 0
