"""The table of faults and reactions: detected, stopped, back, patrolling again.

Each fault is run on a new emulated robot in a small room, driven by the shipped agent process over
pseudo-terminals. Orders and wheel motion are measured on the robot's side of the line. Only
detection and the laser's return come from the recording.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path

from maps.whole_file import write_whole
from tools.campaign.agent_stage import AgentStage, Moment
from tools.campaign.fault import Fault, FaultError
from tools.campaign.loop_disk import NotHereError
from tools.campaign.reaction import (
    AGENT_LIMIT_S,
    RECOVERY_LIMIT_S,
    STOP_LIMIT_S,
    WATCHDOG_LIMIT_S,
    Reaction,
    complaints,
    data_lost,
    first_scan,
    measure_detection,
    measure_stop,
    new_reaction,
    patrols,
    steady_since,
)
from tools.preflight.watchdog_trial import ADVISED_WATCHDOG_S

START_LIMIT_S = 40.0
"""Limit from an agent's start until the robot patrols, s."""
WATCHED_S = 15.0
"""Time a robot is observed after a fault, s."""


def run_fault(fault: Fault, folder: Path, watchdog: float = ADVISED_WATCHDOG_S) -> Reaction:
    """Run one fault on a new robot in an empty folder; takes about 15 s.

    watchdog: value in the base's FLASH, s.

    Raises FaultError if the robot does not begin to patrol before the fault.
    """
    reaction = new_reaction(fault)
    with closing(AgentStage(folder, watchdog=watchdog)) as stage:
        stage.sabotage = fault.sabotage
        if fault.name.startswith("operator"):
            stage.start_operator()
        if fault.with_camera:
            stage.mount_camera()
        try:
            fault.prepare(stage)
        except NotHereError as error:
            reaction.skipped = str(error)
            return reaction
        stage.start_agent()
        _wait_for_patrol(stage)
        begun = time.monotonic()
        fault.begin(stage)
        _watch(stage, fault.lasts)
        stands, sessions = stage.tap.is_standing, stage.tap.sessions
        stage.tap.forget()
        ended = time.monotonic()
        fault.end(stage)
        after = _watch(
            *(stage, max(WATCHED_S, reaction.recover_within)),
            until=lambda seen: patrols(seen) and not (fault.to_border and stage.off_border > 0.15),
        )
        reaction.hunger = stage.service.longest_hunger(begun, after[-1].t)
        stage.sabotage = ""
        stage.end_agent()
    watched = [moment for moment in stage.trace if begun <= moment.t <= after[-1].t]
    measure_stop(reaction, begun, watched)
    measure_detection(reaction, begun, after[-1].t, stage.recordings[0])
    if patrols(after) and not (fault.to_border and stage.off_border > 0.15):
        since = after[-1].t if fault.to_border else steady_since(after)
        reaction.recovered = max(0.0, since - ended)
    reaction.data_lost = data_lost(stage.ends, stage.recordings)
    if fault.of_laser:
        reaction.back = first_scan(ended, stage.recordings[0])
    elif stage.tap.first_order:
        reaction.back = stage.tap.first_at - ended
    # A robot already ordered to stand, in the same session, needs no first order to stand.
    held_on = stands and stage.tap.sessions == sessions
    reaction.first_order = "" if held_on else stage.tap.first_order
    reaction.contacts = stage.world.contacts
    reaction.complaints = complaints(reaction)
    return reaction


def _wait_for_patrol(stage: AgentStage) -> None:
    """Step until the robot patrols at speed and is not just ordered to stand."""

    def at_speed(seen: Sequence[Moment]) -> bool:
        return patrols(seen) and seen[-1].v > 0.25 and not seen[-1].order

    if not at_speed(_watch(stage, START_LIMIT_S, until=at_speed)):
        raise FaultError(f"the robot did not begin to patrol: {stage.agent_log()}")


def _watch(
    stage: AgentStage,
    duration: float,
    until: Callable[[Sequence[Moment]], bool] = lambda _: False,
) -> list[Moment]:
    """Step for ``duration`` s or until ``until`` is true; return all moments, at least one."""
    moments = [stage.step()]
    while moments[-1].t - moments[0].t < duration and not until(moments):
        moments.append(stage.step())
    return moments


def run_faults(
    faults: Sequence[Fault],
    report: Callable[[Reaction], None] = lambda _: None,
    keep: Path | None = None,
    watchdog: float = ADVISED_WATCHDOG_S,
) -> list[Reaction]:
    """Run faults one after the other; ``report`` is called with each reaction.

    keep: folder in which each fault's recordings are kept, in a folder of its name; None: nowhere.
    """
    reactions = []
    for fault in faults:
        with tempfile.TemporaryDirectory(prefix="patrol-fault-") as folder:
            reactions.append(run_fault(fault, Path(folder), watchdog))
            if keep is not None:
                _keep_recordings(Path(folder), keep / fault.name)
        report(reactions[-1])
    return reactions


def _keep_recordings(source: Path, target: Path) -> None:
    target.mkdir(parents=True, exist_ok=True)
    for recording in sorted(source.glob("*.mcap")):
        write_whole(target / recording.name, recording.read_bytes())


HEADINGS = (
    "fault",
    "detected s",
    "by",
    "ordered to stand s",
    "by",
    "at rest s",
    "back s",
    "first order",
    "patrolling again s",
    "contacts",
    "data lost s",
    "verdict",
)


def row(reaction: Reaction) -> tuple[str, ...]:
    """Return a reaction's cells in the order of ``HEADINGS``."""
    return (
        reaction.what,
        _seconds(reaction.detected),
        reaction.detected_by,
        _seconds(reaction.ordered),
        reaction.ordered_by,
        _seconds(reaction.stopped),
        _seconds(reaction.back),
        reaction.first_order,
        _seconds(reaction.recovered),
        str(reaction.contacts),
        f"{reaction.data_lost:.2f}",
        "; ".join(reaction.complaints)
        or (reaction.skipped and f"skipped: {reaction.skipped}")
        or "ok",
    )


def _seconds(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"


def markdown(reactions: Sequence[Reaction]) -> str:
    """Return the table in Markdown."""
    lines = [HEADINGS, tuple("---" for _ in HEADINGS), *map(row, reactions)]
    table = "\n".join(f"| {' | '.join(cells)} |" for cells in lines)
    return f"{table}\n\n{NOTE}\n"


NOTE = (
    "Detected, ordered, at rest: since the fault began. Back (base commanded again, or a scan "
    "understood again), patrolling again: since it ended, which is the cable's return or the "
    "agent's new start. First order: of those that move or stop. Limits: ordered to stand within "
    f"{AGENT_LIMIT_S:g} s where the agent sees the fault and can still command, else within the "
    f"base's watchdog of {WATCHDOG_LIMIT_S:g} s; at rest within {STOP_LIMIT_S:g} s; back "
    "within 1 s where the robot is still in session, 2 s after any "
    f"other return of a cable; patrolling again within {RECOVERY_LIMIT_S:g} s; first order to "
    "stand; no contact."
)
