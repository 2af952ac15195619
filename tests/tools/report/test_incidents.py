"""Incidents of synthetic runs with one fault each."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from robot_agent.messages.streams import DeviceStatus, LocalizationStatus
from robot_agent.recording.run_header import RunHeader
from tools.report.incidents import Span, gate_times, incidents, merged
from tools.report.run_log import LinkChange, LogLine, RunLog, _Process, _Status

HEADER = RunHeader(robot="anna", team="t", seed=0, software_version="", start_wall_ns=0)


def device(state: str, bad: int = 0) -> DeviceStatus:
    return DeviceStatus(
        state=state,
        link_up=True,
        packets_good=1,
        packets_bad=bad,
        bytes_discarded=0,
        bytes_received=1,
    )


def status(base: DeviceStatus, laser: DeviceStatus) -> _Status:
    return _Status("ok", base, laser, LocalizationStatus(health="localized"))


def sound_run() -> RunLog:
    """Return a run of 20 s in which the robot drives without a fault."""
    run = RunLog(Path("anna.mcap"), HEADER, end=20.0, shutdown_at=20.0)
    run.decision_t = np.arange(0.0, 20.0, 0.1)
    run.pose = np.column_stack((0.03 * np.arange(200), np.zeros(200), np.zeros(200)))
    run.gate = [""] * 200
    run.status_t = np.arange(0.0, 20.0, 0.5)
    run.status = [status(device("ready"), device("streaming"))] * 40
    run.received = {link: np.arange(0.0, 20.0, 0.1) for link in ("base", "laser")}
    run.tick_t = np.arange(0.0, 20.0, 0.05)
    run.order_t, run.moving_order = np.array([0.5]), np.array([True])
    return run


def test_run_without_faults_has_no_incident() -> None:
    assert incidents(sound_run()) == []


def test_silent_base_with_its_reaction() -> None:
    run = sound_run()
    run.received["base"] = run.received["base"][
        (run.received["base"] < 5) | (run.received["base"] > 8)
    ]
    run.order_t, run.moving_order = np.array([0.5, 5.2, 8.6]), np.array([True, False, True])
    run.shift = 100.0
    (found,) = incidents(run)
    assert found.what == "base silent"
    assert (found.start, found.end) == pytest.approx((104.9, 108.1))
    assert found.stopped_after == pytest.approx(0.3)
    assert found.moved_after == pytest.approx(0.5)
    assert "stop command after 0.30 s" in found.reaction


def test_lost_port_is_the_only_incident_of_its_silence_and_session() -> None:
    run = sound_run()
    run.links = [
        LinkChange(0.0, "laser", up=True, reason=""),
        LinkChange(6.0, "laser", up=False, reason="gone"),
        LinkChange(9.0, "laser", up=True, reason=""),
    ]
    run.received["laser"] = run.received["laser"][
        (run.received["laser"] < 6) | (run.received["laser"] > 9.5)
    ]
    run.status = [
        status(device("ready"), device("pausing" if 6 <= t < 9.5 else "streaming"))
        for t in run.status_t
    ]
    assert [found.what for found in incidents(run)] == ["laser port lost"]


def test_line_noise_is_one_incident_with_its_count() -> None:
    run = sound_run()
    run.status = [
        status(device("ready", bad=max(0, min(7, index - 10))), device("streaming"))
        for index in range(40)
    ]
    assert [found.what for found in incidents(run)] == ["base line noise: 7 bad packets"]


def test_frozen_agent_sends_no_command() -> None:
    run = sound_run()
    run.tick_t = run.tick_t[(run.tick_t < 4) | (run.tick_t > 7)]
    (found,) = incidents(run)
    assert found.what == "agent frozen"
    assert "watchdog" in found.reaction


def test_killed_agent_is_a_truncated_recording() -> None:
    run = sound_run()
    run.shutdown_at, run.truncated = None, "readable up to byte 7"
    (found,) = incidents(run)
    assert found.what.startswith("recording breaks off")
    assert found.start == 20.0


def test_pose_jump_lost_pose_and_absent_operator_are_incidents() -> None:
    run = sound_run()
    run.pose[120:, 1] += 0.5
    run.lines = [
        LogLine(1.0, 2, "localization", "localized"),
        LogLine(12.0, 4, "localization", "lost"),
        LogLine(14.0, 2, "localization", "localized"),
    ]
    run.process_t = np.arange(1.0, 20.0)
    run.process = [
        _Process(0.1, 90.0, 0.001, 0.002, operator=not 15 <= t < 18) for t in run.process_t
    ]
    found = [(incident.what.split(":")[0], incident.start) for incident in incidents(run)]
    assert found == [
        ("localization lost", 12.0),
        ("pose jumped by 0.50 m", 12.0),
        ("operator away", 15.0),
    ]


def test_gate_times_are_summed_by_reason() -> None:
    run = sound_run()
    run.gate[50:60] = ["obstacle"] * 10
    run.gate[100:130] = ["obstacle"] * 30
    times = gate_times(run)
    assert times["obstacle"][0] == 2
    assert times["obstacle"][1] == pytest.approx(4.0)
    assert [found.what for found in incidents(run)] == ["held by the gate: obstacle ahead"]


def test_spans_of_a_kind_are_joined() -> None:
    spans = [Span(0, 1, "a"), Span(1.5, 2, "a"), Span(1.2, 1.3, "b"), Span(4, 5, "a")]
    assert merged(spans) == [Span(0, 2, "a"), Span(4, 5, "a"), Span(1.2, 1.3, "b")]
