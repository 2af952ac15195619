"""Faults of the robot's computer, of the agent's process, and of the network."""

from __future__ import annotations

import os
import resource
import signal

from tools.campaign.agent_stage import AgentStage
from tools.campaign.fault import (
    IN_SESSION_LIMIT_S,
    NEW_AGENT_LIMIT_S,
    Expected,
    Fault,
    do_nothing,
    sending,
)
from tools.campaign.journal_pipe import JournalPipe

_HUNG_S = 9.0
"""s that a disk or pipe hangs: longer than the agent takes for slow, and than its watchdog."""


def _fill_disk(stage: AgentStage) -> None:
    stage.limit_agent(resource.RLIMIT_FSIZE, stage.recordings[-1].stat().st_size)


def _free_disk(stage: AgentStage) -> None:
    stage.limit_agent(resource.RLIMIT_FSIZE, resource.RLIM_INFINITY)


def _freeze_disk(stage: AgentStage) -> None:
    assert stage.disk is not None
    stage.disk.freeze()


def _thaw_disk(stage: AgentStage) -> None:
    assert stage.disk is not None
    stage.disk.thaw()


def _keep_pose(stage: AgentStage) -> None:
    stage.pose_file = stage.folder / "pose.json"


def _hang_pose_file(stage: AgentStage) -> None:
    """Let the next pose wait for a reader that does not come."""
    assert stage.pose_file is not None
    new = stage.pose_file.with_name(stage.pose_file.name + ".new")
    new.unlink(missing_ok=True)
    os.mkfifo(new)


def _free_pose_file(stage: AgentStage) -> None:
    assert stage.pose_file is not None
    new = stage.pose_file.with_name(stage.pose_file.name + ".new")
    with new.open("rb") as reader:
        reader.read()


def _pipe_journal(stage: AgentStage) -> None:
    stage.journal = JournalPipe(stage.folder / "journal.log")


def _hang_journal(stage: AgentStage) -> None:
    """Let the pipe take no line, then have the agent write one: that its clock is not set."""
    assert stage.journal is not None
    stage.journal.hang()
    stage.signal_agent(signal.SIGUSR1)


def _free_journal(stage: AgentStage) -> None:
    assert stage.journal is not None
    stage.journal.go_on()


def _take_memory(stage: AgentStage) -> None:
    stage.limit_agent(resource.RLIMIT_AS, 1)


def _throttle(stage: AgentStage) -> None:
    """Let the agent run a fifth of the time: stopped for 0.4 s, running for 0.1 s."""
    freeze, go_on = sending(signal.SIGSTOP), sending(signal.SIGCONT)
    stage.later(
        *(
            (0.5 * turn + at, lambda do=do: do(stage))
            for turn in range(8)
            for at, do in ((0.0, freeze), (0.4, go_on))
        )
    )


def _flood(stage: AgentStage) -> None:
    stage.stop_operator()
    stage.flood()


def _end_flood(stage: AgentStage) -> None:
    stage.end_flood()
    stage.start_operator()


def _thread_dies(thread: str, what: str, expected: Expected) -> Fault:
    name = thread.strip("/") + "-thread"
    begin = sending(signal.SIGUSR1)
    return Fault(
        *(name, what, begin, lambda stage: stage.start_agent(), expected),
        recover_within=NEW_AGENT_LIMIT_S,
        sabotage=thread,
    )


COMPUTER_FAULTS: tuple[Fault, ...] = (
    Fault(
        "agent-frozen",
        "agent gets SIGSTOP, then SIGCONT",
        sending(signal.SIGSTOP),
        sending(signal.SIGCONT),
        Expected.BASE_STOPS,
        back_within=IN_SESSION_LIMIT_S,
    ),
    Fault(
        "agent-killed",
        "agent gets SIGKILL, is started again",
        sending(signal.SIGKILL),
        lambda stage: stage.start_agent(),
        Expected.BASE_STOPS,
        recover_within=NEW_AGENT_LIMIT_S,
    ),
    Fault(
        "agent-ended",
        "agent gets SIGTERM, is started again",
        sending(signal.SIGTERM),
        lambda stage: stage.start_agent(),
        Expected.AGENT_STOPS,
        recover_within=NEW_AGENT_LIMIT_S,
    ),
    Fault(
        "operator-absent",
        "operator's machine leaves the network, comes back",
        lambda stage: stage.stop_operator(),
        lambda stage: stage.start_operator(),
        Expected.MAY_PATROL,
    ),
    Fault(
        "disk-full",
        "disk takes no more of the recording",
        _fill_disk,
        _free_disk,
        Expected.MAY_PATROL,
    ),
    Fault(
        "disk-hangs",
        "disk of the recording takes no write for 9 s",
        _freeze_disk,
        _thaw_disk,
        Expected.PATROLS_ON,
        prepare=lambda stage: stage.mount_disk(),
        lasts=_HUNG_S,
    ),
    Fault(
        "pose-file-hangs",
        "file of the pose memory takes no write for 9 s",
        _hang_pose_file,
        _free_pose_file,
        Expected.PATROLS_ON,
        prepare=_keep_pose,
        lasts=_HUNG_S,
    ),
    Fault(
        "journal-hangs",
        "journal takes no line for 9 s",
        _hang_journal,
        _free_journal,
        Expected.PATROLS_ON,
        prepare=_pipe_journal,
        lasts=_HUNG_S,
        sabotage="clock",
    ),
    Fault(
        "memory-gone",
        "agent gets no more memory; is started again",
        _take_memory,
        lambda stage: stage.start_agent(),
        Expected.MAY_PATROL,
        recover_within=NEW_AGENT_LIMIT_S,
    ),
    Fault(
        "cpu-hogged",
        "agent runs 0.1 s of every 0.5 s",
        _throttle,
        do_nothing,
        Expected.AGENT_STOPS,
        lasts=4.5,
        order_within=0.6,  # it is held for the first 0.4 s
    ),
    Fault(
        "clock-jump",
        "wall clock jumps back nine years",
        sending(signal.SIGUSR1),
        do_nothing,
        Expected.MAY_PATROL,
        sabotage="clock",
    ),
    Fault(
        "operator-floods",
        "garbage from the operator's place, as fast as it goes",
        _flood,
        _end_flood,
        Expected.MAY_PATROL,
    ),
    _thread_dies("/base", "base's link thread dies; agent started again", Expected.BASE_STOPS),
    _thread_dies("/laser", "laser's link thread dies; agent started again", Expected.AGENT_STOPS),
    _thread_dies("camera", "camera's thread dies; agent started again", Expected.MAY_PATROL),
    _thread_dies("recorder", "recorder's thread dies; agent started again", Expected.MAY_PATROL),
    _thread_dies("telemetry", "telemetry's thread dies; agent started again", Expected.MAY_PATROL),
)
