"""Summary tables of a demo from true positions and the agents' recorded decisions."""

from __future__ import annotations

import json
from bisect import bisect_right
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from maps.border import Border
from robot_agent.messages.effects import Publish
from robot_agent.messages.streams import DecisionPayload, decode
from robot_agent.patrol.actions import Action
from tools.logs.recording import read_recording
from tools.metrics.metrics import (
    RobotRun,
    action_share,
    distance_from_border,
    meetings,
    patrolling_distances,
    reach_time,
    spread,
)

METRES = "{:.3f}".format


def read_runs(truth_path: Path, recordings: dict[str, Path]) -> tuple[list[RobotRun], int]:
    """Join true positions with the recorded decisions by time.

    truth_path: JSON lines of the world process; recordings: file of each robot by name. Returns the
    runs, times from the first line, and the number of contacts.
    """
    rows = [json.loads(line) for line in truth_path.read_text().splitlines()]
    t = np.array([row["t"] for row in rows])
    runs = []
    for name, path in recordings.items():
        times, decisions = _decisions(path)
        in_force = [bisect_right(times, moment) - 1 for moment in t]
        runs.append(
            RobotRun(
                name=name,
                t=t - t[0],
                position=np.array([row["poses"][name][:2] for row in rows]),
                action=[decisions[index].action if index >= 0 else "" for index in in_force],
                direction=np.array(
                    [decisions[index].direction if index >= 0 else 0 for index in in_force],
                    dtype=np.int8,
                ),
            )
        )
    return runs, rows[-1]["contacts"]


def _decisions(path: Path) -> tuple[list[float], list[DecisionPayload]]:
    """Return times, s on the machine's monotonic clock, and decisions of a recording."""
    recording = read_recording(path)
    start = recording.header.start_monotonic_ns / 1e9
    times, decisions = [], []
    t = 0.0
    for item in recording.items():
        t = getattr(item, "t", t)  # an effect happens at its event's time
        if isinstance(item, Publish) and item.stream == "decision":
            payload = decode(item.stream, item.payload)
            assert isinstance(payload, DecisionPayload)
            times.append(start + t)
            decisions.append(payload)
    return times, decisions


def print_summary(border: Border, runs: Sequence[RobotRun], contacts: int) -> None:
    """Print the table per robot, the time in each action, the meetings and the contacts."""
    console = Console(highlight=False)
    console.print(_robot_table(border, runs))
    console.print(_action_table(runs))
    console.print(_meeting_table(border, runs))
    console.print(f"contacts: {contacts}")


def _robot_table(border: Border, runs: Sequence[RobotRun]) -> Table:
    table = Table(title="distance from border while patrolling (true positions)")
    for column in ("robot", "reached border (s)", "median (m)", "p95 (m)", "max (m)", "meetings"):
        table.add_column(column, justify="left" if column == "robot" else "right")
    met = meetings(border, runs)
    for run in runs:
        distance = distance_from_border(border, run)
        reached = reach_time(run, distance)
        patrolling = spread(patrolling_distances(run, distance))
        figures = [patrolling[key] for key in ("median", "p95", "max")]
        table.add_row(
            run.name,
            "never" if reached is None else f"{reached:.1f}",
            *("-" if figure is None else METRES(figure) for figure in figures),
            str(sum(run.name in meeting.robots for meeting in met)),
        )
    return table


def _action_table(runs: Sequence[RobotRun]) -> Table:
    table = Table(title="time in each action (%)")
    table.add_column("robot")
    for action in Action:
        table.add_column(str(action), justify="right")
    for run in runs:
        share = action_share([run])
        table.add_row(run.name, *(f"{100 * share[str(action)]:.1f}" for action in Action))
    return table


def _meeting_table(border: Border, runs: Sequence[RobotRun]) -> Table:
    table = Table(title="meetings")
    for column in ("at (s)", "robots", "actions", "closest (m)", "ended"):
        table.add_column(column)
    for meeting in meetings(border, runs):
        table.add_row(
            f"{meeting.t:.1f}",
            " and ".join(meeting.robots),
            " and ".join(meeting.actions),
            f"{meeting.closest_m:.2f}",
            meeting.outcome,
        )
    return table
