"""Faults done to a patrolling robot, and how it takes them: detected, stopped, patrolling again.

Each fault gets an emulated robot of its own in a small room, driven by the shipped agent process
over pseudo-terminals. All that decides is measured on the robot's side of the line: which order it
was under, how its wheels turned. Only the time to detect comes from the agent's own recording.
"""

from __future__ import annotations

import math
import signal
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path

from drivers.p2os.commands import CLOSE
from drivers.p2os.settings import BaseSettings
from robot_agent.agent import STOPPING
from robot_agent.effects import Publish
from robot_agent.foxglove import Log
from robot_agent.streams import decode
from tools.bench.agent_stage import AgentStage, Moment
from tools.recording import read_recording

START_LIMIT_S = 25.0
"""How long an agent may take from its start until the robot patrols."""
STEADY_S = 0.7
"""A robot that has moved this long without a break patrols."""
STANDING_S = 0.3
"""Wheels at rest this long have stopped; in a turn they pass zero for less."""
AGENT_LIMIT_S = 0.5
"""Within this the agent must have ordered a stop where it can see the fault and still command."""
WATCHDOG_LIMIT_S = 2.0
"""Within this the base must have begun to stop by itself where the agent cannot."""
STOP_LIMIT_S = 2.0
"""Within this the wheels must be at rest; the ramp comes on top where the watchdog stops them."""
RECOVERY_LIMIT_S = 10.0
WATCHED_S = 15.0
"""How long a robot is given to recover."""
_SAMPLING_S = 0.05  # of the emulator's steps and its watchdog, on a loaded machine


class FaultError(ValueError):
    """A fault could not be run; the message says why."""


class Expected(StrEnum):
    """What a robot must do about a fault."""

    AGENT_STOPS = "agent stops"
    """The agent can see the fault and still command."""
    BASE_STOPS = "base stops"
    """Only the base itself can: its controller or its watchdog."""
    MAY_PATROL = "may patrol"
    """The fault can be lived with; stopping for it is no failure."""


@dataclass(frozen=True, slots=True)
class Fault:
    """Something done to a robot for a while."""

    name: str
    what: str
    begin: Callable[[AgentStage], None]
    end: Callable[[AgentStage], None]
    expected: Expected
    lasts: float = 4.0
    """s"""


@dataclass(slots=True)
class Reaction:
    """How the robot took a fault; times in s since the fault began, None: did not happen."""

    fault: str
    what: str
    expected: Expected
    detected: float | None = None
    """First event or standing order."""
    detected_by: str = ""
    ordered: float | None = None
    """Under orders to stand."""
    ordered_by: str = ""
    stopped: float | None = None
    """Wheels at rest."""
    recovered: float | None = None
    """Moving again, since the fault's end."""
    first_order: str = ""
    """First motion order after the fault's end."""
    speed: float = 0.0
    """m/s when the fault began."""
    contacts: int = 0
    complaints: list[str] = field(default_factory=list)


def _mute_base(stage: AgentStage) -> None:
    stage.base_line.mute = True


def _cut_base(stage: AgentStage) -> None:
    stage.base_line.mute = stage.base_line.deaf = True


def _mend_base(stage: AgentStage) -> None:
    stage.base_line.mute = stage.base_line.deaf = False
    stage.base_line.corrupt = 0.0


def _spoil_base(stage: AgentStage) -> None:
    stage.base_line.corrupt = 0.2


def _reset_base(stage: AgentStage) -> None:
    """What a reset leaves: session closed, motors off, waiting for SYNC0."""
    stage.rig.base.feed(CLOSE.encode(), stage.step().t)


def _mute_laser(stage: AgentStage) -> None:
    stage.laser_line.mute = True


def _spoil_laser(stage: AgentStage) -> None:
    stage.laser_line.corrupt = 0.2


def _mend_laser(stage: AgentStage) -> None:
    stage.laser_line.mute = False
    stage.laser_line.corrupt = 0.0


def _send(number: signal.Signals) -> Callable[[AgentStage], None]:
    return lambda stage: stage.signal_agent(number)


def _do_nothing(_stage: AgentStage) -> None:
    """The fault is over as soon as it has happened."""


FAULTS: tuple[Fault, ...] = (
    Fault(
        "base-unplugged",
        "base's cable unplugged, replugged",
        lambda stage: stage.base_cable.pull(),
        lambda stage: stage.base_cable.put_back(),
        Expected.BASE_STOPS,
    ),
    Fault(
        "base-cut",
        "base's line dead both ways, port stays",
        _cut_base,
        _mend_base,
        Expected.BASE_STOPS,
    ),
    Fault(
        "base-silent",
        "base hears, its reports are lost",
        _mute_base,
        _mend_base,
        Expected.AGENT_STOPS,
    ),
    Fault(
        "base-noise",
        "20 % of the base's packets corrupt",
        _spoil_base,
        _mend_base,
        Expected.MAY_PATROL,
    ),
    Fault(
        "base-reset",
        "base resets: session closed, motors off",
        _reset_base,
        _do_nothing,
        Expected.BASE_STOPS,
        lasts=0.0,
    ),
    Fault(
        "laser-unplugged",
        "laser's cable unplugged, replugged",
        lambda stage: stage.laser_cable.pull(),
        lambda stage: stage.laser_cable.put_back(),
        Expected.AGENT_STOPS,
    ),
    Fault("laser-silent", "laser's scans are lost", _mute_laser, _mend_laser, Expected.AGENT_STOPS),
    Fault(
        "laser-noise",
        "20 % of the laser's telegrams corrupt",
        _spoil_laser,
        _mend_laser,
        Expected.MAY_PATROL,
    ),
    Fault(
        "laser-power",
        "laser switched off, then on: power-on telegram",
        lambda stage: stage.rig.laser.power_off(stage.step().t),
        lambda stage: stage.rig.laser.power_on(stage.step().t),
        Expected.AGENT_STOPS,
    ),
    Fault(
        "agent-frozen",
        "agent gets SIGSTOP, then SIGCONT",
        _send(signal.SIGSTOP),
        _send(signal.SIGCONT),
        Expected.BASE_STOPS,
    ),
    Fault(
        "agent-killed",
        "agent gets SIGKILL, is started again",
        _send(signal.SIGKILL),
        lambda stage: stage.start_agent(),
        Expected.BASE_STOPS,
    ),
    Fault(
        "agent-ended",
        "agent gets SIGTERM, is started again",
        _send(signal.SIGTERM),
        lambda stage: stage.start_agent(),
        Expected.AGENT_STOPS,
    ),
    Fault(
        "operator-absent",
        "operator's machine leaves the network, comes back",
        lambda stage: stage.dismiss_operator(),
        lambda stage: stage.seat_operator(),
        Expected.MAY_PATROL,
    ),
)


def run_fault(fault: Fault, folder: Path) -> Reaction:
    """Run one fault on a robot of its own in an empty folder; takes about 20 s.

    Raises FaultError if the robot does not come to patrol in the first place.
    """
    with AgentStage(folder) as stage:
        if fault.name == "operator-absent":
            stage.seat_operator()
        stage.start_agent()
        before = _wait_for_patrol(stage)
        reaction = Reaction(fault.name, fault.what, fault.expected, speed=before.v)
        fault.begin(stage)
        trace = _watch(stage, fault.lasts)
        fault.end(stage)
        stage.tap.forget()
        after = _watch(stage, WATCHED_S, until=_patrols)
        stage.end_agent()
    begun, ended = trace[0].t, after[0].t
    _measure_stop(reaction, begun, [*trace, *after])
    if _patrols(after):
        reaction.recovered = _steady_since(after) - ended
    reaction.first_order = stage.tap.first_since
    reaction.contacts = stage.world.contacts
    _note_detection(reaction, begun, stage.recordings[0])
    reaction.complaints = complaints(reaction)
    return reaction


def _wait_for_patrol(stage: AgentStage) -> Moment:
    """Step until the robot patrols at speed."""
    moments = _watch(stage, START_LIMIT_S, until=lambda seen: _patrols(seen) and seen[-1].v > 0.25)
    if not _patrols(moments):
        raise FaultError(f"the robot did not begin to patrol: {stage.agent_log()}")
    return moments[-1]


def _watch(
    stage: AgentStage,
    duration: float,
    until: Callable[[Sequence[Moment]], bool] = lambda _: False,
) -> list[Moment]:
    """Step for a duration, s, or until something is so; return every moment, one at least."""
    moments = [stage.step()]
    while moments[-1].t - moments[0].t < duration and not until(moments):
        moments.append(stage.step())
    return moments


def _steady_since(moments: Sequence[Moment]) -> float:
    """Return since when the robot has been moving without a break, up to the last moment."""
    since = math.inf
    for moment in reversed(moments):
        if not moment.moving:
            break
        since = moment.t
    return since


def _patrols(moments: Sequence[Moment]) -> bool:
    return moments[-1].t - _steady_since(moments) >= STEADY_S


def _measure_stop(reaction: Reaction, begun: float, moments: Sequence[Moment]) -> None:
    """Find the first standing order and when the wheels came to rest."""
    for number, moment in enumerate(moments):
        if reaction.ordered is None and moment.order:
            reaction.ordered, reaction.ordered_by = moment.t - begun, moment.order
        if moment.standing and _stays_standing(moments[number:]):
            reaction.stopped = moment.t - begun
            return


def _stays_standing(moments: Sequence[Moment]) -> bool:
    for moment in moments:
        if not moment.standing:
            return False
        if moment.t - moments[0].t >= STANDING_S:
            return True
    return False


def _note_detection(reaction: Reaction, begun: float, path: Path) -> None:
    """Take the first thing the agent said of the fault, else the first standing order."""
    recording = read_recording(path)
    start = 1e-9 * recording.header.start_monotonic_ns
    t = 0.0
    for item in recording.items():
        if not isinstance(item, Publish):
            t = getattr(item, "t", t)
            continue
        if item.stream == "event" and start + t > begun:
            said = _alarm(item)
            if said:
                reaction.detected, reaction.detected_by = start + t - begun, said
                break
    if reaction.ordered is not None and (
        reaction.detected is None or reaction.ordered < reaction.detected
    ):
        reaction.detected, reaction.detected_by = reaction.ordered, reaction.ordered_by


def _alarm(item: Publish) -> str:
    """Return what an event says of a fault, if it does."""
    log = decode("event", item.payload)
    assert isinstance(log, Log)
    if log.name in ("base", "laser") and log.message != "port open":
        return f"event: {log.name}"
    held = log.name == "gate" and log.message in {f"gate: {reason}" for reason in STOPPING}
    return f"event: {log.message}" if held else ""


def complaints(reaction: Reaction) -> list[str]:
    """Return in what the reaction falls short."""
    found = []
    if reaction.contacts:
        found.append(f"{reaction.contacts} contacts")
    if reaction.recovered is None or reaction.recovered > RECOVERY_LIMIT_S:
        found.append(f"not patrolling within {RECOVERY_LIMIT_S:g} s")
    if reaction.expected is Expected.MAY_PATROL:
        return found
    by_agent = reaction.expected is Expected.AGENT_STOPS
    order_limit = (AGENT_LIMIT_S if by_agent else WATCHDOG_LIMIT_S) + _SAMPLING_S
    if reaction.ordered is None or reaction.ordered > order_limit:
        found.append(f"no standing order within {order_limit - _SAMPLING_S:g} s")
    ramp = 0.0 if by_agent else abs(reaction.speed) / BaseSettings().deceleration
    if reaction.stopped is None or reaction.stopped > STOP_LIMIT_S + ramp + _SAMPLING_S:
        found.append(f"not at rest within {STOP_LIMIT_S + ramp:.1f} s")
    if reaction.first_order not in ("", "STOP", "VEL 0", "RVEL 0", "CLOSE", "ENABLE"):
        found.append(f"first order after it was {reaction.first_order}")
    return found


def run_faults(
    faults: Sequence[Fault], tell: Callable[[Reaction], None] = lambda _: None
) -> list[Reaction]:
    """Run faults one after the other; ``tell`` hears of each as it is done."""
    reactions = []
    for fault in faults:
        with tempfile.TemporaryDirectory(prefix="patrol-fault-") as folder:
            reactions.append(run_fault(fault, Path(folder)))
        tell(reactions[-1])
    return reactions


def chosen_faults(names: Sequence[str]) -> list[Fault]:
    """Return the faults of these names, all of them if there is none; raises FaultError."""
    known = {fault.name: fault for fault in FAULTS}
    unknown = [name for name in names if name not in known]
    if unknown:
        raise FaultError(f"no fault {unknown[0]!r}; faults are {', '.join(known)}")
    return [known[name] for name in names] or list(FAULTS)


HEADINGS = (
    "fault",
    "detected s",
    "by",
    "ordered to stand s",
    "by",
    "at rest s",
    "patrolling again s",
    "contacts",
    "verdict",
)


def row(reaction: Reaction) -> tuple[str, ...]:
    """Return a reaction as the cells below ``HEADINGS``."""
    return (
        reaction.what,
        _seconds(reaction.detected),
        reaction.detected_by,
        _seconds(reaction.ordered),
        reaction.ordered_by,
        _seconds(reaction.stopped),
        _seconds(reaction.recovered),
        str(reaction.contacts),
        "; ".join(reaction.complaints) or "ok",
    )


def _seconds(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"


def markdown(reactions: Sequence[Reaction]) -> str:
    """Return the table in Markdown."""
    lines = [HEADINGS, tuple("---" for _ in HEADINGS), *map(row, reactions)]
    table = "\n".join(f"| {' | '.join(cells)} |" for cells in lines)
    return f"{table}\n\n{NOTE}\n"


NOTE = (
    "Times since the fault began; patrolling again: since it ended (the cable's return, the "
    "agent's new start). Limits: ordered to stand within "
    f"{AGENT_LIMIT_S:g} s where the agent sees the fault and can still command, else within the "
    f"base's watchdog of {WATCHDOG_LIMIT_S:g} s; at rest within {STOP_LIMIT_S:g} s, after the "
    f"watchdog plus its ramp; patrolling again within {RECOVERY_LIMIT_S:g} s; no contact."
)
