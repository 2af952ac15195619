"""The agent in lockstep with emulated devices: effects of events."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import pytest

from drivers.lms200.session import SessionState as LaserState
from drivers.p2os.commands import CommandNumber
from drivers.p2os.session import SessionState
from localization.health import Health
from maps.map_folder import MapFolder, load_map_folder
from maps.pose import Pose
from robot_agent.agent import Agent
from robot_agent.config import AgentConfig, find_map
from robot_agent.messages.effects import Publish
from robot_agent.messages.events import BytesReceived, LinkDown, LinkUp, Shutdown, Tick
from robot_agent.messages.foxglove import Log
from robot_agent.messages.streams import DecisionPayload, StatusPayload, decode
from robot_agent.motion.freshness_limits import LASER
from robot_agent.motion.gate import SafetyGate
from robot_agent.motion.gate_reason import GateReason
from robot_agent.motion.gate_settings import gate_limits
from robot_agent.patrol.patrol import PATROLLING
from tests.robot_agent.tape import Tape
from tools.bench.bench_fault import parse_fault
from tools.bench.fleet import Fleet
from tools.simulation.truth.truth import load_truth

START = Pose(5.0, 13.4, 0.3)
MOTION = (CommandNumber.VEL, CommandNumber.RVEL, CommandNumber.VEL2)


@pytest.fixture(scope="module")
def folder() -> MapFolder:
    return load_map_folder(find_map("paper_lab", Path()))


def make_fleet(folder: MapFolder, tape: Tape | None = None) -> Fleet:
    return Fleet(folder, 1, seed=5, starts=[START], observer=(lambda *_: tape) if tape else None)


def run_until(fleet: Fleet, t: float) -> None:
    while fleet.t < t:
        fleet.step()


def test_connects_localizes_and_patrols(folder: MapFolder) -> None:
    fleet = make_fleet(folder)
    run_until(fleet, 30.0)  # at 25 s it turns round by chance
    agent = fleet.robots[0].agent
    assert agent.base.state is SessionState.READY
    assert agent.laser.state is LaserState.STREAMING
    assert agent.localizer.estimate is not None
    assert agent.localizer.estimate.health is Health.LOCALIZED
    assert agent.decision is not None
    assert agent.decision.action in PATROLLING
    assert agent.decision.distance_from_border < 0.1
    assert agent.health_summary.health() == "ok"
    assert fleet.robots[0].rig.base.velocity[0] == pytest.approx(0.35, abs=0.1)
    assert fleet.world.contacts == 0


def test_the_first_motion_command_is_zero_and_limits_come_before_motors(folder: MapFolder) -> None:
    tape = Tape()
    run_until(make_fleet(folder, tape), 10.0)
    sent = tape.sent_to_base()
    numbers = [number for number, _ in sent]
    enabled = sent.index((CommandNumber.ENABLE, 1))
    for limit in (CommandNumber.SETV, CommandNumber.SETRV, CommandNumber.SETA, CommandNumber.SETRA):
        assert numbers.index(limit) < enabled
    motion = [(n, v) for n, v in sent if n in (CommandNumber.VEL, CommandNumber.RVEL)]
    assert motion[0] == (CommandNumber.VEL, 0)
    assert motion[1] == (CommandNumber.RVEL, 0)
    first_moving = next(
        i for i, (n, v) in enumerate(sent) if n in (CommandNumber.VEL, CommandNumber.RVEL) and v
    )
    assert enabled < first_moving


def test_shutdown_leaves_the_robot_standing_with_motors_off(folder: MapFolder) -> None:
    tape = Tape()
    fleet = make_fleet(folder, tape)
    run_until(fleet, 15.0)
    assert fleet.robots[0].rig.base.velocity[0] > 0.1
    fleet.shut_down()
    last = tape.sent_to_base()[-3:]
    assert last[0] == (CommandNumber.STOP, last[0][1])
    assert last[1] == (CommandNumber.ENABLE, 0)
    assert last[2][0] == CommandNumber.CLOSE
    run_until(fleet, 17.0)
    assert fleet.robots[0].rig.base.velocity == (0.0, 0.0)


def test_device_that_closes_its_connection_at_the_end_is_no_fault(folder: MapFolder) -> None:
    fleet = make_fleet(folder)
    run_until(fleet, 5.0)
    agent = fleet.robots[0].agent
    agent.handle(Shutdown(5.0))
    for link in ("base", "laser"):
        effects = agent.handle(LinkDown(5.1, link, "connection closed by the other side"))
        assert not [one for one in effects if isinstance(one, Publish) and one.stream == "event"]
    effects = agent.handle(LinkUp(5.2, "base"))
    assert effects == []
    assert agent.base.state is SessionState.DOWN


def test_the_same_events_give_the_same_effects(folder: MapFolder) -> None:
    tape = Tape()
    fleet = make_fleet(folder, tape)
    run_until(fleet, 20.0)
    agent = Agent(fleet.robots[0].agent.config, folder)
    for event, effects in tape.steps:
        assert agent.handle(event) == effects


def test_blind_laser_stops_the_robot(folder: MapFolder) -> None:
    fleet = make_fleet(folder)
    run_until(fleet, 15.0)
    robot = fleet.robots[0]
    assert robot.rig.base.velocity[0] > 0.1
    robot.rig.laser.power_off(fleet.t)
    run_until(fleet, 15.5)
    assert robot.agent.gate_decision is not None
    assert robot.agent.gate_decision.reason is GateReason.STALE_LASER
    run_until(fleet, 17.0)
    assert robot.rig.base.velocity == (0.0, 0.0)
    assert (
        "laser" in robot.agent.health_summary.health()
        or "gate" in robot.agent.health_summary.health()
    )
    robot.rig.laser.power_on(fleet.t)
    run_until(fleet, 30.0)
    assert robot.rig.base.velocity[0] > 0.1, "goes on by itself once the laser is back"


def test_blind_laser_is_reported_and_robot_stands(folder: MapFolder) -> None:
    tape = Tape()
    fault = parse_fault("robot1:blind@15-22")
    starts = [START]
    fleet = Fleet(folder, 1, 5, starts=starts, observer=lambda *_: tape, faults=[fault])
    standing_by = 15.0 + LASER.max_age + 0.1  # s: the gate's limit, and a report's period
    run_until(fleet, 15.0)
    assert fleet.robots[0].rig.base.velocity[0] > 0.1
    run_until(fleet, standing_by)
    blinded = len(tape.steps)
    run_until(fleet, 22.0)
    in_the_dark = Tape()
    in_the_dark.steps = tape.steps[blinded:]
    ordered = [v for n, v in in_the_dark.sent_to_base() if n in MOTION]
    assert ordered
    assert not any(ordered), "nothing is ordered but to stand"
    told = [payload for payload in _published(in_the_dark, "status") if payload.degraded]
    assert told, "status says what is missing"
    assert "laser blind" in told[-1].degraded[0]
    said = [payload.message for payload in _published(in_the_dark, "event")]
    assert sum("laser blind" in words for words in said) == 1, "and an event says it once"
    run_until(fleet, 32.0)
    assert fleet.world.contacts == 0
    last = _published(tape, "status")[-1]
    assert not last.degraded
    assert fleet.robots[0].rig.base.velocity[0] > 0.1, "goes on once it sees again"


def _published(tape: Tape, stream: str) -> list[Any]:
    return [
        decode(stream, effect.payload)
        for effect in tape.effects()
        if isinstance(effect, Publish) and effect.stream == stream
    ]


def test_lost_base_link_is_reported(folder: MapFolder) -> None:
    fleet = make_fleet(folder)
    run_until(fleet, 15.0)
    agent = fleet.robots[0].agent
    agent.handle(LinkDown(round(fleet.t, 6), "base", "unplugged"))
    assert agent.base.state is SessionState.DOWN
    assert agent.health_summary.health() == "base down"


def test_without_a_border_agent_localizes_and_never_moves(folder: MapFolder) -> None:
    tape = Tape()
    bare = replace(folder, border=None)
    run_until(make_fleet(bare, tape), 12.0)
    assert not any(
        number in (CommandNumber.VEL, CommandNumber.RVEL) and value
        for number, value in tape.sent_to_base()
    )
    assert (CommandNumber.ENABLE, 1) not in tape.sent_to_base()
    estimates = [e for e in tape.effects() if isinstance(e, Publish) and e.stream == "particles"]
    assert estimates, "it localizes all the same"


def test_without_a_start_agent_localizes_globally(folder: MapFolder) -> None:
    config = AgentConfig()
    assert config.start is None
    agent = Agent(config, folder)
    assert agent.localizer.estimate is None
    assert agent.handle(Tick(0.0))


def test_every_payload_fits_its_stream(folder: MapFolder) -> None:
    tape = Tape()
    run_until(make_fleet(folder, tape), 12.0)
    published = [effect for effect in tape.effects() if isinstance(effect, Publish)]
    assert {p.stream for p in published} == {
        "status",
        "decision",
        "pose",
        "scan",
        "particles",
        "tracks",
        "event",
    }
    payloads = [decode(p.stream, p.payload) for p in published]
    decisions = [p for p in payloads if isinstance(p, DecisionPayload)]
    assert all(set(d.degrees) and d.winner in d.degrees for d in decisions)
    statuses = [p for p in payloads if isinstance(p, StatusPayload)]
    assert statuses[-1].health == "ok"
    assert statuses[-1].base.packets_bad == 0


def test_noise_on_both_links_is_counted_and_nothing_else(folder: MapFolder) -> None:
    agent = Agent(AgentConfig(), folder)
    noise = bytes(range(256)) * 4
    for step, link in enumerate(("base", "laser") * 20):
        agent.handle(BytesReceived(step * 0.01, link, noise))  # type: ignore[arg-type]
    agent.handle(Shutdown(1.0))


def test_a_bumper_stops_the_robot_before_it_pushes(folder: MapFolder) -> None:
    fleet = make_fleet(folder)
    run_until(fleet, 15.0)
    robot = fleet.robots[0]
    robot.rig.base.set_contact(stalled=False, front_bumpers=0b00100, rear_bumpers=0)
    state = robot.agent.odometry.latest
    assert state is not None
    inputs = robot.agent._gate_inputs(fleet.t, replace(state, front_bumpers=0b00100))
    decision = robot.agent.gate.permit(fleet.t, (0.3, 0.0), inputs)
    assert (decision.v, decision.w, decision.reason) == (0.0, 0.0, GateReason.BUMPER)


def test_sonar_echo_behind_slows_a_turn_towards_it(folder: MapFolder) -> None:
    fleet = make_fleet(folder)
    run_until(fleet, 15.0)
    agent = fleet.robots[0].agent
    state = agent.odometry.latest
    assert state is not None
    behind = replace(state, sonar=((11, 0.1), (12, 0.1)))
    agent.surroundings.on_sonar(behind, Pose(state.x, state.y, state.theta), None)
    inputs = msgspec.structs.replace(agent._gate_inputs(state.t, state), v=0.0, w=0.0, bumpers=0)
    with_sonar, without = (
        msgspec.structs.replace(inputs, obstacles=points)
        for points in (inputs.obstacles, inputs.obstacles[inputs.obstacles[:, 0] > -0.3])
    )
    turns = []
    for seen in (with_sonar, without):
        gate = SafetyGate(gate_limits(agent.config.gate, agent.base.model))
        for step in range(10):
            t = state.t + 0.1 * step
            at = msgspec.structs.replace(seen, base_time=t, scan_time=t)
            decision = gate.permit(t, (0.0, 1.5), at)
        turns.append(decision)
    assert turns[0].w < turns[1].w
    assert turns[0].reason is GateReason.OBSTACLE


def test_late_handling_is_an_overload_and_stops_the_robot(folder: MapFolder) -> None:
    tape = Tape()
    run_until(make_fleet(folder, tape), 15.0)
    agent = Agent(make_fleet(folder).robots[0].agent.config, folder)
    reasons = []
    for event, _ in tape.steps:
        if event.t > 12.0 and isinstance(event, BytesReceived):
            agent.handle(Tick(round(event.t + 0.12, 6)))  # the inbox is 0.12 s behind
        agent.handle(event)
        if agent.gate_decision is not None:
            reasons.append(agent.gate_decision.reason)
    assert GateReason.OVERLOADED not in reasons[: len(reasons) // 2]
    assert agent.freshness.deadline.missed > 3
    assert agent.gate_decision is not None
    assert agent.gate_decision.reason is GateReason.OVERLOADED
    assert agent.gate_decision.v == 0.0


def test_lost_robot_turns_slowly_and_relocalizes(folder: MapFolder) -> None:
    fleet = make_fleet(folder)
    robot = fleet.robots[0]
    robot.agent.localizer.start_anywhere()
    speeds, turns = [], []
    while fleet.t < 60.0 and not robot.agent.pose_tracker.trusted:
        fleet.step()
        v, w = robot.rig.base.velocity
        speeds.append(abs(v))
        turns.append(abs(w))
    assert robot.agent.pose_tracker.trusted, "it must find itself"
    assert max(speeds) < 0.01
    assert 0.3 < max(turns) < 0.55
    assert fleet.world.contacts == 0
    found = robot.agent.localizer.estimate
    assert found is not None
    assert found.pose.x == pytest.approx(robot.rig.body.pose.x, abs=0.3)
    assert found.pose.y == pytest.approx(robot.rig.body.pose.y, abs=0.3)


def test_laser_mounted_otherwise_stops_the_robot_and_names_the_setting(folder: MapFolder) -> None:
    tape = Tape()
    fleet = Fleet(
        folder,
        1,
        seed=5,
        starts=[START],
        observer=lambda *_: tape,
        truth=load_truth("laser_turned_45"),
    )
    run_until(fleet, 15.0)
    agent = fleet.robots[0].agent
    assert agent.pose_tracker.health is Health.LOST
    assert agent.gate_decision is not None
    assert agent.gate_decision.reason is GateReason.LASER_MOUNT
    assert agent.health_summary.health() == "laser.mount: turned"
    assert any("turned about" in log.message for log in _published(tape, "event"))
    assert fleet.world.contacts == 0
    assert math.dist(fleet.robots[0].rig.body.pose[:2], START[:2]) < 1.2


def test_own_parts_in_view_stop_the_robot_and_are_named(folder: MapFolder) -> None:
    fleet = Fleet(folder, 3, seed=2, truth=load_truth("own_parts"))
    agent = fleet.robots[1].agent  # the others have no room to turn by more than what they see
    run_until(fleet, 20.0)
    assert agent.gate_decision is not None
    assert agent.gate_decision.reason is GateReason.LASER_MOUNT
    assert "ignore" in agent.health_summary.health()
    words = agent.warnings["laser.ignore"]
    assert words.startswith("the laser sees parts of the robot at 2")
    assert "set laser.ignore = [[" in words


def test_own_parts_of_a_model_with_its_laser_upside_down_are_named_as_the_setting_wants_them(
    folder: MapFolder,
) -> None:
    """A post to the left is at 166 degrees of an upright scanner, at 14 of one turned over."""
    tape = Tape()
    truth = load_truth("powerbot")
    fleet = Fleet(folder, 1, seed=2, starts=[START], truth=truth, observer=lambda *_: tape)
    run_until(fleet, 4.0)
    fleet.robots[0].agent.own_parts.sectors = ((math.radians(75.0), math.radians(78.0)),)
    run_until(fleet, 4.5)
    assert [words[-29:] for words in tape.logged("laser.ignore")] == [
        "set laser.ignore = [[12, 15]]"
    ]


def test_robot_held_from_the_start_says_that_its_laser_is_not_confirmed(folder: MapFolder) -> None:
    fleet = Fleet(folder, 3, seed=3, truth=load_truth("laser_turned_180"))
    agent = fleet.robots[0].agent
    run_until(fleet, 24.0)
    assert not agent.pose_tracker.travel.confirmed
    assert "correct laser.mount" in agent.warnings["laser.mount"]
    assert fleet.world.contacts == 0


def test_stale_stream_raises_an_alarm_until_it_is_fresh(folder: MapFolder) -> None:
    tape = Tape()
    fleet = make_fleet(folder, tape)
    run_until(fleet, 8.0)
    fleet.robots[0].rig.laser.power_off(fleet.t)
    run_until(fleet, 10.0)
    fleet.robots[0].rig.laser.power_on(fleet.t)
    run_until(fleet, 22.0)
    events = [e for e in tape.effects() if isinstance(e, Publish) and e.stream == "event"]
    alarms = [decode("event", event.payload) for event in events]
    words = [a.message for a in alarms if isinstance(a, Log) and a.name == "trust.laser"]
    assert words == ["laser scan: none for 0.34 s: the robot stands", "laser scan: is back"]


def test_bytes_buffered_during_a_pause_are_rejected(folder: MapFolder) -> None:
    fleet = make_fleet(folder)
    run_until(fleet, 15.0)
    robot = fleet.robots[0]
    known = robot.agent.odometry.latest
    assert known is not None
    scan_seen = robot.agent.surroundings.seen_at
    devices = {"base": robot.rig.base, "laser": robot.rig.laser}
    waiting = {"base": b"", "laser": b""}
    moment = fleet.t
    for _ in range(200):  # 2 s in which the agent's process is held up
        moment = round(moment + 0.01, 6)
        robot.rig.advance(moment)
        for link, device in devices.items():
            waiting[link] += b"".join(item.data for item in device.pop_output(moment))
    robot.agent.handle(Tick(moment))
    for link, old in waiting.items():
        assert old
        robot.agent.handle(BytesReceived(moment, link, old))  # type: ignore[arg-type]
    assert robot.agent.odometry.latest is known
    assert robot.agent.surroundings.seen_at == scan_seen
