"""Rows: power cuts, a full disk, a clock that is not set, recordings afterwards."""

from __future__ import annotations

from tools.field.disk_check import examine_disk
from tools.field.fault_rows import REST_LIMIT_S
from tools.field.field_row import FieldRow, Outcome
from tools.field.field_stage import PATROL_LIMIT_S, FieldStage, drives, stands
from tools.field.journal import says, starts
from tools.logs.recording import read_recording

CUTS = 2
DRIVEN_S = 15.0
"""Driving before a cut, s."""
LOST_LIMIT_S = 1.5
"""Limit of what a cut costs at a recording's end, s: a second by the recorder, and its reading."""
RECORDINGS = "/var/lib/patrol"
FILLER = "/filler"
LEFT_MB = 50
"""Room left on a disk that is filled, MB: below the file's recorder.leave_free_mb."""
NOTICED_S = 30.0
REPLAY_LIMIT_S = 600.0
RESUMED_S = 90.0
"""Limit until recording goes on, s; a full disk is tried again after at most 60 s."""
LONG_AGO = "2000-01-01"


def _power_cuts(stage: FieldStage, outcome: Outcome) -> None:
    stage.boot()
    ends: list[float] = []
    for number in range(1, CUTS + 1):
        outcome.within("drives after", stage.robot.wait(drives, PATROL_LIMIT_S), PATROL_LIMIT_S)
        stage.clock.sleep(DRIVEN_S)
        ends.append(stage.guest.uptime())
        begun = stage.robot.now
        stage.machine.cut_power()
        rest = stage.robot.wait(stands, REST_LIMIT_S, begun)
        outcome.within("at rest after the cut", rest, REST_LIMIT_S)
        wrong = examine_disk(stage.disk, stage.folder / "cut.raw")
        outcome.require(not wrong, f"cut {number}: {wrong}")
        stage.power_on()
    outcome.within("drives after", stage.robot.wait(drives, PATROL_LIMIT_S), PATROL_LIMIT_S)
    outcome.require(stage.robot.contacts == 0, f"{stage.robot.contacts} contacts")
    stage.machine.shut_down()
    _recordings(stage, outcome, ends)


def _recordings(stage: FieldStage, outcome: Outcome, ends: list[float]) -> None:
    """Replay every recording on the computer that made it; measure what the cuts cost."""
    guest = stage.workbench(backing=stage.disk)
    names = guest.run(f"ls {RECORDINGS}/*.mcap").split()
    outcome.require(len(names) == len(ends) + 1, f"{len(names)} recordings")
    for name in names:
        done = guest.attempt(f"patrol replay --check {name}", REPLAY_LIMIT_S)
        last = done.output.strip().splitlines()[-1] if done.output.strip() else ""
        outcome.require(done.status == 0, f"replay of {name}: {last}")
    outcome.note(f"{len(names)} recordings replayed identically")
    for end, name in zip(ends, names, strict=False):
        copy = stage.folder / "cut.mcap"
        copy.write_bytes(guest.read(name))
        recording = read_recording(copy)
        lost = end - recording.header.start_monotonic_ns / 1e9 - recording.end()
        outcome.within("lost", max(0.0, lost), LOST_LIMIT_S)


def _full_disk(stage: FieldStage, outcome: Outcome) -> None:
    stage.patrolling()
    stage.spoil()
    before = starts(stage.journal())
    stage.guest.run(_fill(LEFT_MB))
    noticed = stage.wait_for_line("too little room", NOTICED_S)
    outcome.require(noticed is not None, "the journal does not say that recording pauses")
    outcome.require(stage.robot.wait(drives, 10.0) is not None, "does not drive on")
    stage.guest.run(f"rm {FILLER}")
    resumed = _grows(stage, RESUMED_S)
    outcome.within("recording resumed after", resumed, RESUMED_S)
    outcome.require(starts(stage.journal()) == before, "the service was started again")
    outcome.require(stage.robot.contacts == 0, f"{stage.robot.contacts} contacts")


def _full_disk_at_boot(stage: FieldStage, outcome: Outcome) -> None:
    stage.boot(change=_fill(0))
    stage.spoil()
    outcome.within("drives after", stage.robot.wait(drives, PATROL_LIMIT_S), PATROL_LIMIT_S)
    said = stage.wait_for_line("recorder", NOTICED_S)
    outcome.require(said is not None, "the journal does not say that nothing is recorded")
    outcome.require(starts(stage.journal()) == 1, "the service was started again")


def _fill(left_mb: int) -> str:
    """Return shell lines that leave a number of MB on the disk."""
    return (
        f"free=$(df -m --output=avail / | tail -1); fallocate -l $((free - {left_mb}))M {FILLER}; "
        f"test {left_mb} -gt 0 || cat /dev/zero > {FILLER}2 2> /dev/null; sync"
    )


def _grows(stage: FieldStage, limit: float) -> float | None:
    """Return after how many s a robot's newest recording grows; None if not within the limit."""
    sizes = f"cat {RECORDINGS}/*.mcap | wc -c"
    begun, first = stage.clock.now(), int(stage.guest.run(sizes))
    while (passed := stage.clock.now() - begun) < limit:
        if int(stage.guest.run(sizes)) > first:
            return passed
        stage.clock.sleep(1.0)
    return None


def _clock_not_set(stage: FieldStage, outcome: Outcome) -> None:
    stage.boot()
    outcome.within("drives after", stage.robot.wait(drives, PATROL_LIMIT_S), PATROL_LIMIT_S)
    stage.machine.shut_down()
    stage.power_on(clock_starts=LONG_AGO)
    outcome.within("and then after", stage.robot.wait(drives, PATROL_LIMIT_S), PATROL_LIMIT_S)
    names = stage.guest.run(f"cd {RECORDINGS} && ls *.mcap").split()
    outcome.note(
        f"recordings {' and '.join(names)}, clock {stage.guest.run('date -Idate').strip()}"
    )
    counters = [name.split("-")[1] for name in names]
    outcome.require(counters == ["000001", "000002"], "the runs are not numbered 1 and 2")
    outcome.require(says(stage.journal(), "clock"), "the journal does not say that it is not set")
    stage.spoil()


POWER_ROWS = (
    FieldRow(
        "power-cut",
        f"power cut {CUTS} times while it drives, each time switched on again",
        "file system in order, at most "
        f"{LOST_LIMIT_S:g} s of a recording lost, every recording replays identically, drives",
        _power_cuts,
    ),
    FieldRow(
        "disk-full",
        f"disk filled to {LEFT_MB} MB while it drives, then freed",
        "drives on, the journal says so, recording goes on with the room",
        _full_disk,
    ),
    FieldRow(
        "boot-disk-full",
        "switched on with no byte free",
        "drives, the journal says so",
        _full_disk_at_boot,
    ),
    FieldRow(
        "boot-year-2000",
        f"switched on with a clock at {LONG_AGO}, after a run",
        "drives, runs numbered by starts, the journal says so",
        _clock_not_set,
    ),
)
