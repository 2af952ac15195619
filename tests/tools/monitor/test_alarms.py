"""Alarms from simulated telemetry: raised within 2 s of their cause, and cleared."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np
import pytest

from robot_agent.agent import Agent
from robot_agent.config import AgentConfig
from robot_agent.messages.foxglove import Log, SceneUpdate, timestamp_at, track_entity
from robot_agent.messages.log_level import LogLevel
from robot_agent.messages.streams import (
    HeldBy,
    LocalizationStatus,
    Payload,
    ProcessPayload,
    StatusPayload,
    Twist,
    encode,
)
from robot_agent.motion.gate_reason import GateReason
from robot_agent.motion.gate_words import GATE_WORDS
from robot_agent.motion.obstacle_points import ObstacleSource
from robot_agent.patrol.modifier import OverrideReason
from robot_agent.patrol.turn_log import TurnCause
from robot_agent.report.notices import TURN_WORDS
from tests.tools.monitor.agent_recordings import FOLDER
from tests.tools.monitor.reports import decision, device, status
from tools.monitor.alarm import Condition, Severity
from tools.monitor.alarm_board import MAX_ALARMS, Alarm, AlarmBoard
from tools.monitor.reason import (
    OVERRIDE_WORDS,
    SOURCE_WORDS,
    turn_words,
    why,
)
from tools.monitor.robot_state import RobotState
from tools.monitor.site import Site
from tools.monitor.team_state import TeamState
from tools.monitor.watch import Watch

KEY = "patrol/north/anna"
CAUSE, END, LAST = 10.0, 20.0, 40.0
PayloadsAt = Callable[[float], dict[str, Payload]]


def without_fault(t: float) -> dict[str, Payload]:
    return {"status": status(t), "decision": decision(t)}


def alarms_of(trouble: PayloadsAt) -> list[Alarm]:
    """Return the alarms of a run with a fault's telemetry from CAUSE to END, else without fault."""
    team = TeamState()
    watch = Watch(team, Site(None))
    for step in range(round(LAST / 0.1)):
        t = 0.1 * step
        payloads = trouble(t) if CAUSE <= t < END else without_fault(t)
        for stream, payload in payloads.items():
            if stream != "status" or step % 5 == 0:
                team.receive(f"{KEY}/{stream}", encode(payload), t, t)
        watch.advance(t + 0.05, t + 0.05)
    return watch.alarms.alarms()


def with_status(**changes: Any) -> PayloadsAt:
    return lambda t: {"status": status(t, **changes), "decision": decision(t)}


def held(t: float) -> dict[str, Payload]:
    held = decision(t, command=Twist(0.0, 0.0), gate_reason="obstacle")
    return {"status": status(t), "decision": held}


def late(t: float) -> dict[str, Payload]:
    return {"status": msgspec.structs.replace(status(t), timestamp=timestamp_at(t - 5.0))}


def intruder(t: float) -> dict[str, Payload]:
    entity = track_entity(
        timestamp_at(t), 7, (3.0, 4.0), (0.0, 0.0), kind="intruder", probability=0.9
    )
    return {**without_fault(t), "tracks": SceneUpdate(entities=[entity])}


TROUBLES: dict[str, tuple[PayloadsAt, Severity, str]] = {
    "silent": (lambda t: {}, Severity.CRITICAL, "nothing received for"),
    "lost": (
        with_status(localization=LocalizationStatus(health="lost")),
        Severity.CRITICAL,
        "localization lost",
    ),
    "stalled": (with_status(stalled=True), Severity.CRITICAL, "a motor is stalled"),
    "bumper": (with_status(bumpers=2), Severity.CRITICAL, "a bumper is pressed"),
    "gate": (held, Severity.WARNING, "held by the gate: obstacle ahead"),
    "battery": (with_status(battery=11.3), Severity.WARNING, "battery at 11.3 V"),
    "link laser": (
        with_status(laser=device("lost", link_up=False, link_reason="unplugged")),
        Severity.CRITICAL,
        "laser: unplugged",
    ),
    "link base": (
        with_status(base=device("connecting")),
        Severity.CRITICAL,
        "base: connecting, not ready",
    ),
    "intruder": (intruder, Severity.CRITICAL, "intruder at 3.0, 4.0 m"),
    "clock": (late, Severity.WARNING, "clock is 5.0 s behind this computer's; set it"),
}


@pytest.mark.parametrize("kind", TROUBLES)
def test_alarm_appears_within_two_seconds_and_clears(kind: str) -> None:
    trouble, severity, text = TROUBLES[kind]
    (alarm,) = alarms_of(trouble)
    assert (alarm.robot, alarm.kind, alarm.severity) == ("north/anna", kind, severity)
    assert alarm.text.startswith(text)
    assert CAUSE <= alarm.raised < CAUSE + 2.0
    assert alarm.cleared is not None
    assert END <= alarm.cleared < END + 3.0


@pytest.mark.parametrize(
    ("silence", "words"),
    [(2.6, "3 s"), (19.9, "10 s"), (59.0, "50 s"), (150.0, "2 min"), (7300.0, "2 h")],
)
def test_silence_is_told_ever_more_coarsely(silence: float, words: str) -> None:
    team = TeamState()
    watch = Watch(team, Site(None))
    team.receive(f"{KEY}/status", encode(status(1.0)), 1.0, 1.0)
    watch.advance(1.0 + silence, 1.0 + silence)
    assert watch.alarms.alarms()[0].text == f"nothing received for {words}, connection gone"


def test_robot_without_faults_raises_no_alarm() -> None:
    assert alarms_of(without_fault) == []


def test_starting_robot_raises_no_alarm() -> None:
    def starting(t: float) -> dict[str, Payload]:
        closed = device("idle", link_up=False, link_reason="not opened yet")
        lost = LocalizationStatus(health="lost")
        up = t - CAUSE
        if up > 4.0:
            return without_fault(t)
        return {"status": status(t, uptime=up, base=closed, laser=closed, localization=lost)}

    assert alarms_of(starting) == []


def log_entry(name: str, level: LogLevel, t: float) -> Log:
    return Log(timestamp=timestamp_at(t), level=level, message="somebody is there", name=name)


@pytest.mark.parametrize(("name", "kind"), [("intruder", "intruder"), ("patrol", "blocked")])
def test_warning_in_the_log_is_an_alarm_for_a_while(name: str, kind: str) -> None:
    def once(t: float) -> dict[str, Payload]:
        words: dict[str, Payload] = {"event": log_entry(name, LogLevel.WARNING, t)}
        return {**without_fault(t), **(words if t < CAUSE + 0.05 else {})}

    (alarm,) = alarms_of(once)
    assert (alarm.kind, alarm.text) == (kind, "somebody is there")
    assert alarm.raised < CAUSE + 1.0
    assert alarm.cleared is not None


def test_missing_input_is_an_alarm_until_its_return_is_reported() -> None:
    def missed(t: float) -> dict[str, Payload]:
        first, last = t < CAUSE + 0.05, t > END - 0.15
        level = LogLevel.ERROR if first else LogLevel.INFO
        words: dict[str, Payload] = {"event": log_entry("trust.laser", level, t)}
        return {**without_fault(t), **(words if first or last else {})}

    (alarm,) = alarms_of(missed)
    assert (alarm.kind, alarm.severity) == ("trust.laser", Severity.CRITICAL)
    assert alarm.raised < CAUSE + 1.0
    assert alarm.cleared is not None
    assert END - 1.0 < alarm.cleared < END + 2.0


def test_every_gate_reason_has_a_text() -> None:
    assert set(GATE_WORDS) == set(GateReason) - {GateReason.NONE}


def test_an_unplugged_laser_is_one_alarm() -> None:
    lost = device("down", link_up=False, link_reason="unplugged")

    def unplugged(t: float) -> dict[str, Payload]:
        back = t > END - 0.15
        stale = Log(
            timestamp=timestamp_at(t),
            level=LogLevel.INFO if back else LogLevel.ERROR,
            message="is back" if back else "none for 0.34 s",
            name="trust.laser",
        )
        return {
            "status": status(t, laser=lost, localization=LocalizationStatus(health="lost")),
            "decision": decision(t, command=Twist(0.0, 0.0), gate_reason="stale_laser"),
            "event": stale,
        }

    assert [alarm.text for alarm in alarms_of(unplugged)] == ["laser: unplugged"]


def test_consequence_told_before_its_cause_is_no_alarm_of_its_own() -> None:
    board = AlarmBoard()
    early = Condition("north/anna", "trust.laser", Severity.CRITICAL, "none for 0.4 s", 0.8)
    cause = Condition("north/anna", "link laser", Severity.CRITICAL, "laser: unplugged")
    for step in range(60):
        board.update([early] if step < 5 else [cause], 0.1 * step, 0.0)
    assert [alarm.kind for alarm in board.alarms()] == ["link laser"]


def test_failing_recorder_of_a_robot_is_an_alarm() -> None:
    def failing(t: float) -> dict[str, Payload]:
        process = ProcessPayload(
            timestamp=timestamp_at(t),
            robot="anna",
            cpu=0.1,
            memory_mb=90.0,
            events=100,
            lateness_median=0.001,
            lateness_max=0.01,
            recorder_trouble="full",
        )
        return {**without_fault(t), "process": process}

    (alarm,) = alarms_of(failing)
    assert (alarm.kind, alarm.text) == ("recorder", "full")


def condition(kind: str = "battery", severity: Severity = Severity.WARNING) -> Condition:
    return Condition("north/anna", kind, severity, f"{kind} {severity.name}")


@pytest.mark.parametrize(
    ("changes", "kind"),
    [
        ({}, None),
        ({"map_hash": ""}, None),
        ({"map_hash": "other"}, "map"),
        ({"map_hash": "other", "border_hash": "other"}, "map"),
        ({"border_hash": "other"}, "border"),
    ],
)
def test_map_or_border_that_is_not_the_monitors_is_one_alarm(
    changes: dict[str, str], kind: str | None
) -> None:
    team, site = TeamState(), Site(FOLDER)
    watch = Watch(team, site)
    map_hash, border_hash = site.hashes
    told = {"map_hash": map_hash, "border_hash": border_hash, **changes}
    team.receive(f"{KEY}/status", encode(status(1.0, **told)), 1.0, 1.0)
    watch.advance(1.1, 1.1)
    assert [alarm.kind for alarm in watch.alarms.alarms()] == ([] if kind is None else [kind])


def test_agents_tell_the_hashes_that_the_monitor_compares() -> None:
    agent = Agent(AgentConfig(), FOLDER)
    payloads = dict(agent.telemetry.on_time(0.0))
    told = payloads["status"]
    assert isinstance(told, StatusPayload)
    assert (told.map_hash, told.border_hash) == Site(FOLDER).hashes


def test_intruder_comes_before_other_critical_alarms() -> None:
    board = AlarmBoard()
    board.update([condition("intruder", Severity.CRITICAL)], 0.0, 0.0)
    board.update([condition(kind, Severity.CRITICAL) for kind in ("intruder", "lost")], 0.5, 0.0)
    assert [alarm.kind for alarm in board.alarms()] == ["intruder", "lost"]


def test_flickering_condition_is_one_alarm() -> None:
    board = AlarmBoard()
    for step in range(100):
        board.update([condition()] if step % 3 else [], 0.2 * step, 0.0)
    (alarm,) = board.alarms()
    assert alarm.active


def test_acknowledged_alarm_is_unacknowledged_when_its_severity_rises() -> None:
    board = AlarmBoard()
    board.update([condition()], 0.0, 0.0)
    (alarm,) = board.alarms()
    board.acknowledge(alarm.number, "Mia", 17.0)
    board.acknowledge(999)
    (seen,) = board.alarms()
    assert (seen.acknowledged, seen.acknowledged_by, seen.acknowledged_wall) == (True, "Mia", 17.0)
    board.update([condition(severity=Severity.CRITICAL)], 0.1, 0.0)
    (alarm,) = board.alarms()
    assert (alarm.severity, alarm.acknowledged) == (Severity.CRITICAL, False)


def test_active_alarms_come_first_acknowledged_or_not_and_the_worst_of_them_before() -> None:
    board = AlarmBoard()
    board.update([condition("a"), condition("b", Severity.CRITICAL), condition("c")], 0.0, 0.0)
    first = board.alarms()[0]
    assert first.kind == "b"
    board.acknowledge(first.number)
    assert [alarm.kind for alarm in board.alarms()] == ["b", "c", "a"]
    for step in range(1, 20):
        board.update([condition("a")], 0.1 * step, 0.0)
    assert [alarm.kind for alarm in board.alarms()] == ["a", "b", "c"]


def test_list_of_alarms_is_bounded() -> None:
    board = AlarmBoard()
    rng = np.random.default_rng(1)
    for step in range(3 * MAX_ALARMS):
        kinds = rng.integers(0, 1000, 2)
        board.update([condition(f"kind {kind}") for kind in kinds], 2.0 * step, 0.0)
    assert len(board.alarms()) <= MAX_ALARMS + 4


def test_every_override_turn_and_source_has_a_text() -> None:
    assert set(OVERRIDE_WORDS) == set(OverrideReason)
    assert set(TURN_WORDS) == set(TurnCause)
    assert set(SOURCE_WORDS) == set(ObstacleSource)


def test_reason_text_names_override_turn_and_obstacle() -> None:
    received = RobotState("demo", "robot1").with_payload(
        "decision", decision(1.0, override="closing_in", turn="chance"), 1.0, 1.0
    )
    words = "keeps going clockwise, no teammate near: comes slowly closer than usual"
    assert why(received, 1.0) == words
    assert turn_words(received, 4.2) == "by chance, 3 s ago"
    later = received.with_payload("decision", decision(5.0), 5.0, 5.0)
    assert turn_words(later, 6.0) == "by chance, 5 s ago"
    at = later.decision.pose
    obstacle = HeldBy("map_wall", at.x + 0.3, at.y)
    held = decision(6.0, command=Twist(0.0, 0.0), gate_reason="obstacle", held_by=obstacle)
    words = why(later.with_payload("decision", held, 6.0, 6.0), 6.0)
    assert words == "held by the gate: obstacle ahead, a wall of the map, 0.3 m from its middle"
