"""Soak test: a team under random faults for hours, in lockstep.

Every hour of simulated time gives one row: contacts, idleness, memory, stops, recordings. A
simulated person comes where a gate latch asks for one and switches the motors off and on again.
"""

from __future__ import annotations

import contextlib
import dataclasses
import json
import math
import os
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from maps.map_folder import MapFolder
from maps.whole_file import write_whole
from robot_agent.config import AgentConfig, RecorderSettings
from robot_agent.messages.effects import Effect
from robot_agent.messages.events import Event
from robot_agent.motion.gate_reason import LATCHED, GateReason
from robot_agent.recording.recorder import Recorder
from robot_agent.recording.recording_retention import RecordingRetention
from robot_agent.recording.run_files import NumberedRuns
from robot_agent.recording.run_header import RunHeader, header_of_run
from tools.bench.bench_fault import BenchFault, FaultKind
from tools.bench.fleet import Fleet, FleetRobot
from tools.metrics.border_visits import border_visits
from tools.metrics.idleness import idleness_figures
from tools.simulation.truth.truth import Truth
from tools.simulation.world import Contact

HOUR_S = 3600.0
SAMPLE_S = 0.5
KEEP_MB = 300.0
"""Size of each robot's recordings kept: about five hours, so that old ones are deleted."""
BLIND_DRIVE_S = 4.5
"""Time for which a robot may move after its agent died: the base's watchdog and its ramp."""
PERSON_COMES_S = 20.0
_MEMORY = Path("/proc/self/statm")

_LASTS = {
    FaultKind.DEAD: (1.0, 8.0),
    FaultKind.BLIND: (0.5, 10.0),
    FaultKind.DEAF: (0.5, 10.0),
    FaultKind.STUCK: (0.2, 5.0),
    FaultKind.NOISY: (2.0, 20.0),
    FaultKind.CARRIED: (0.1, 0.2),
    FaultKind.AWAY: (0.1, 0.2),
}
"""Shortest and longest duration of a fault of each kind, s."""


@dataclass(frozen=True, slots=True)
class SoakHour:
    """Figures at the end of one hour of simulated time; counts are since the start."""

    hour: float
    """Simulated time since the start, h."""
    wall_s: float
    faults: int
    contacts: int
    contacts_blind: int
    """Contacts while an agent was killed by a fault: only a base's watchdog could prevent them."""
    idleness_average_s: float | None
    idleness_worst_s: float | None
    memory_mb: float
    gate_stops: int
    latched: int
    """Visits of the person to robots held by a latch of the gate."""
    batteries: int
    """Empty batteries exchanged."""
    recordings_mb: float
    recordings: int
    records_lost: int
    touched: tuple[str, ...] = ()
    """The contacts of this hour: time, s, robot and what it touched."""


def random_faults(robots: int, duration: float, every: float, seed: int) -> list[BenchFault]:
    """Return random faults for each robot, on average ``every`` s apart, until ``duration``, s."""
    rng = np.random.default_rng(seed)
    faults = []
    for number in range(1, robots + 1):
        t = 60.0 + float(rng.exponential(every))
        while t < duration:
            kind = list(_LASTS)[int(rng.integers(len(_LASTS)))]
            lasts = float(rng.uniform(*_LASTS[kind]))
            faults.append(BenchFault(f"robot{number}", kind, round(t, 2), round(t + lasts, 2)))
            t += lasts + float(rng.exponential(every))
    return faults


class HourlyRecording:
    """The flight recorder of one robot with a new file every hour; old ones are deleted."""

    def __init__(self, target: Path, name: str, header: RunHeader) -> None:
        """Start recording to ``target``/<name>-<number>-<time>.mcap."""
        self._target = target
        self._name = name
        self._header = header
        self.lost = 0
        self._recorder = self._start()

    def _start(self) -> Recorder:
        files = NumberedRuns(self._target, self._name)
        settings = RecorderSettings(keep_mb=KEEP_MB, leave_free_mb=0.0)
        return Recorder(files, self._header, room=RecordingRetention(files, settings))

    def record_event(self, event: Event) -> None:
        """Queue an event."""
        self._recorder.record_event(event)

    def record_effect(self, t: float, effect: Effect) -> None:
        """Queue an effect."""
        self._recorder.record_effect(t, effect)

    def rotate(self) -> None:
        """Finish this file and start another."""
        self.close()
        self._recorder = self._start()

    def close(self) -> None:
        """Finish the present file."""
        self._recorder.close()
        self.lost += self._recorder.lost


class Person:
    """A simulated person: releases a latched gate by the MOTORS button, exchanges the battery."""

    def __init__(self, robot: FleetRobot) -> None:
        self._robot = robot
        self._asked_at: float | None = None
        self._pressed_at: float | None = None
        self.visits = 0
        self.batteries = 0

    def watch(self, t: float) -> None:
        """Act at t: PERSON_COMES_S after a request exchange an empty battery, or press twice."""
        base = self._robot.rig.base
        if self._pressed_at is not None:
            if t - self._pressed_at >= 1.0:
                base.press_motors_button()
                self._pressed_at = self._asked_at = None
            return
        gate = self._robot.agent.gate_decision
        empty = gate is not None and gate.reason is GateReason.BATTERY_LOW
        if gate is None or not (empty or gate.reason in LATCHED):
            self._asked_at = None
        elif self._asked_at is None:
            self._asked_at = t
        elif t - self._asked_at < PERSON_COMES_S:
            return
        elif empty:
            self.batteries += 1
            self._asked_at = None
            base.battery.fill()
        else:
            self.visits += 1
            self._pressed_at = t
            base.press_motors_button()


class Soak:
    """Runs a team for hours; ``hours`` yields a row after each simulated hour."""

    def __init__(
        self,
        folder: MapFolder,
        robots: int,
        seed: int,
        duration: float,
        every: float,
        target: Path,
        truth: Truth | None = None,
    ) -> None:
        """Draw the faults and make the team; records to the folder ``target``.

        duration: simulated time, s; every: mean time between two faults of a robot, s. truth: what
        robots and world really are, by default the shipped ``plain``.
        """
        self.duration = duration
        self.recordings: list[HourlyRecording] = []
        self.faults = random_faults(robots, duration, every, seed)
        self._target = target
        target.mkdir(parents=True, exist_ok=True)

        def observe(name: str, config: AgentConfig) -> HourlyRecording:
            header = header_of_run(config, folder, source="soak", start_wall_ns=0)
            self.recordings.append(HourlyRecording(target, name, header))
            return self.recordings[-1]

        self.fleet = Fleet(folder, robots, seed, observer=observe, faults=self.faults, truth=truth)
        self._people = [Person(robot) for robot in self.fleet.robots]
        self._dead_until = [-math.inf] * robots
        self._contacts_blind = 0
        self._contacts_seen = 0
        self._touched: list[str] = []

    def hours(self, progress: Callable[[float], None] = lambda _: None) -> Iterator[SoakHour]:
        """Run to the end; yield a row after each hour."""
        fleet, started = self.fleet, time.monotonic()
        while fleet.t < self.duration:
            until = min(fleet.t + HOUR_S, self.duration)
            times, places = self._run(until, progress)
            for recording in self.recordings:
                recording.rotate()
            yield self._row(times, places, time.monotonic() - started)
        fleet.shut_down()
        for recording in self.recordings:
            recording.close()

    def _run(
        self, until: float, progress: Callable[[float], None]
    ) -> tuple[list[float], list[list[tuple[float, float]]]]:
        fleet = self.fleet
        times: list[float] = []
        places: list[list[tuple[float, float]]] = [[] for _ in fleet.robots]
        next_sample = fleet.t
        while fleet.t < until:
            fleet.step()
            self._count_contacts()
            if fleet.t >= next_sample:
                next_sample += SAMPLE_S
                progress(fleet.t)
                times.append(fleet.t)
                for person, place, robot in zip(self._people, places, fleet.robots, strict=True):
                    person.watch(fleet.t)
                    place.append((robot.rig.body.pose.x, robot.rig.body.pose.y))
        return times, places

    def _count_contacts(self) -> None:
        """Count new contacts, separately those of a robot whose agent died BLIND_DRIVE_S ago."""
        fleet = self.fleet
        for number, robot in enumerate(fleet.robots):
            if robot.injector is not None and robot.injector.agent_dead:
                self._dead_until[number] = fleet.t + BLIND_DRIVE_S
        new = fleet.world.contacts - self._contacts_seen
        if new:
            self._contacts_seen += new
            for contact in fleet.world.contact_log[-new:]:
                other = "a wall" if contact.other is None else self._name(contact.other)
                self._touched.append(f"{fleet.t:.1f} s: {self._name(contact.body)}, {other}")
                self._contacts_blind += self._is_blind(contact)

    def _is_blind(self, contact: Contact) -> bool:
        """Return whether a robot of a contact has, or just had, no agent to stop it."""
        return any(
            until >= self.fleet.t and robot.rig.body.index in (contact.body, contact.other)
            for robot, until in zip(self.fleet.robots, self._dead_until, strict=True)
        )

    def _name(self, body: int) -> str:
        robots = {robot.rig.body.index: robot.rig.name for robot in self.fleet.robots}
        return robots.get(body, f"body {body}")

    def _row(
        self, times: list[float], places: list[list[tuple[float, float]]], wall: float
    ) -> SoakHour:
        fleet = self.fleet
        border = fleet.folder.border
        assert border is not None
        visits = border_visits(border, [np.array(place) for place in places], np.array(times))
        idleness = idleness_figures(visits)["idleness_s"]
        touched, self._touched = self._touched, []
        sizes = recording_sizes(self._target)
        return SoakHour(
            hour=round(fleet.t / HOUR_S, 3),
            wall_s=round(wall, 1),
            faults=sum(fault.start <= fleet.t for fault in self.faults),
            contacts=fleet.world.contacts - self._contacts_blind,
            contacts_blind=self._contacts_blind,
            idleness_average_s=idleness["average"],
            idleness_worst_s=idleness["worst"],
            memory_mb=round(_resident_mb(), 1),
            gate_stops=sum(robot.agent.gate_stops for robot in fleet.robots),
            latched=sum(person.visits for person in self._people),
            batteries=sum(person.batteries for person in self._people),
            recordings_mb=round(sum(sizes) / 1e6, 1),
            recordings=len(sizes),
            records_lost=sum(recording.lost for recording in self.recordings),
            touched=tuple(touched),
        )


def recording_sizes(folder: Path) -> list[int]:
    """Return the size, bytes, of each recording; recorders may delete old ones meanwhile."""
    sizes = []
    for path in folder.glob("*.mcap"):
        with contextlib.suppress(FileNotFoundError):
            sizes.append(path.stat().st_size)
    return sizes


class SoakLog:
    """Writes the rows of a soak to files, hour by hour: a kill loses the last hour only.

    ``path`` gets a JSON line per hour; the summary is beside it as ``.summary.json``.
    """

    def __init__(self, path: Path) -> None:
        """Empty the file, also of an earlier run's rows."""
        self._path = path
        self._rows: list[SoakHour] = []
        write_whole(path, "")

    def add(self, row: SoakHour) -> None:
        """Append an hour's row, and rewrite the summary."""
        self._rows.append(row)
        with self._path.open("a") as file:
            file.write(json.dumps(dataclasses.asdict(row)) + "\n")
        content = json.dumps(summary(self._rows), indent=2) + "\n"
        write_whole(self._path.with_suffix(".summary.json"), content)


def summary(rows: list[SoakHour]) -> dict[str, Any]:
    """Return the summary of a run: its last row, all contacts, speed and slopes per hour."""
    return {
        **dataclasses.asdict(rows[-1]),
        "touched": [words for row in rows for words in row.touched],
        "times_real_time": round(rows[-1].hour * HOUR_S / rows[-1].wall_s, 1),
        "memory_slope_mb_per_hour": slope([(row.hour, row.memory_mb) for row in rows[1:]]),
        "idleness_slope_s_per_hour": slope(
            [(row.hour, row.idleness_average_s) for row in rows if row.idleness_average_s]
        ),
    }


def slope(points: list[tuple[float, float]]) -> float | None:
    """Return the least-squares slope of points (x, y); None for fewer than two."""
    if len(points) < 2:
        return None
    x, y = np.array(points).T
    return round(float(np.polyfit(x, y, 1)[0]), 4)


def _resident_mb() -> float:
    pages = int(_MEMORY.read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20
