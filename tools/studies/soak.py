"""A team under random faults for hours, in lockstep: does anything wear out?

Every hour of simulated time gives one row: contacts, idleness, memory, stops, recordings. Persons
come where a robot asks for one: they switch its motors off and on again.
"""

from __future__ import annotations

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

from drivers.p2os.emulator.battery import FULL
from maps.map_folder import MapFolder
from robot_agent.config import AgentConfig, RecorderSettings
from robot_agent.messages.effects import Effect
from robot_agent.messages.events import Event
from robot_agent.motion.gate_reason import LATCHED, GateReason
from robot_agent.recording.recorder import Recorder
from robot_agent.recording.recording_retention import RecordingRetention
from robot_agent.recording.run_header import RunHeader, header_of_run
from tools.bench.bench_fault import BenchFault, FaultKind
from tools.bench.fleet import Fleet, FleetRobot
from tools.metrics.idleness import border_visits, idleness_figures

HOUR_S = 3600.0
SAMPLE_S = 0.5
KEEP_MB = 120.0
"""Of recordings of each robot: about two hours, so that old ones must go."""
BLIND_DRIVE_S = 4.5
"""For so long a robot whose agent died may still move: the base's watchdog and its ramp."""
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
"""How long a fault of each kind lasts, s, from and to."""


@dataclass(frozen=True, slots=True)
class SoakHour:
    """What one hour of simulated time has shown."""

    hour: float
    """At its end, from the start."""
    wall_s: float
    faults: int
    contacts: int
    contacts_blind: int
    """Of robots whose agent a fault had killed: nothing but the base's watchdog could stop them."""
    idleness_average_s: float | None
    idleness_worst_s: float | None
    memory_mb: float
    gate_stops: int
    latched: int
    """Visits of a person to a robot that asked for one."""
    batteries: int
    """Exchanged when empty."""
    recordings_mb: float
    recordings: int
    records_lost: int
    touched: tuple[str, ...] = ()
    """The contacts of this hour: when each began, s, and who touched what."""


def random_faults(robots: int, duration: float, every: float, seed: int) -> list[BenchFault]:
    """Return faults of every kind for each robot, about ``every`` s apart, up to ``duration``."""
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
    """The live recorder of one robot, with a new run every hour; old ones make room."""

    def __init__(self, target: Path, name: str, header: RunHeader) -> None:
        """Record to ``target``/<name>-<time>.mcap."""
        self._target = target
        self._name = name
        self._header = header
        self._runs = 0
        self.lost = 0
        self._recorder = self._start()

    def _start(self) -> Recorder:
        self._runs += 1
        day, hour = divmod(self._runs - 1, 24)
        path = self._target / f"{self._name}-{20000101 + day}T{hour:02d}0000Z.mcap"
        settings = RecorderSettings(keep_mb=KEEP_MB, leave_free_mb=0.0)
        return Recorder(
            path,
            self._header,
            room=RecordingRetention(path, settings, f"{self._name}-????????T??????Z.mcap"),
        )

    def record_event(self, event: Event) -> None:
        """Queue an event."""
        self._recorder.record_event(event)

    def record_effect(self, t: float, effect: Effect) -> None:
        """Queue an effect."""
        self._recorder.record_effect(t, effect)

    def rotate(self) -> None:
        """End this run and begin another."""
        self.close()
        self._recorder = self._start()

    def close(self) -> None:
        """End the present run."""
        self._recorder.close()
        self.lost += self._recorder.lost


class Person:
    """Looks at a robot that asks for it: motors off, and on again; a full battery for an empty."""

    def __init__(self, robot: FleetRobot) -> None:
        self._robot = robot
        self._asked_at: float | None = None
        self._pressed_at: float | None = None
        self.visits = 0
        self.batteries = 0

    def watch(self, t: float) -> None:
        """Come; exchange an empty battery, else press, wait a second and press again."""
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
            base.battery.volts = FULL
        else:
            self.visits += 1
            self._pressed_at = t
            base.press_motors_button()


class Soak:
    """Runs a team for hours; ``hours`` yields a row after each."""

    def __init__(
        self, folder: MapFolder, robots: int, seed: int, duration: float, every: float, target: Path
    ) -> None:
        """Plan the faults of ``duration`` s, one per robot about ``every`` s; record to target."""
        self.duration = duration
        self.recordings: list[HourlyRecording] = []
        self.faults = random_faults(robots, duration, every, seed)
        self._target = target
        target.mkdir(parents=True, exist_ok=True)

        def observe(name: str, config: AgentConfig) -> HourlyRecording:
            header = header_of_run(config, folder, source="soak", start_wall_ns=0)
            self.recordings.append(HourlyRecording(target, name, header))
            return self.recordings[-1]

        self.fleet = Fleet(folder, robots, seed, observer=observe, faults=self.faults)
        self._people = [Person(robot) for robot in self.fleet.robots]
        self._dead_until = [-math.inf] * robots
        self._contacts_blind = 0
        self._contacts_seen = 0
        self._touched: list[str] = []

    def hours(self, progress: Callable[[float], None] = lambda _: None) -> Iterator[SoakHour]:
        """Run to the end, an hour at a time."""
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
            self._blame()
            if fleet.t >= next_sample:
                next_sample += SAMPLE_S
                progress(fleet.t)
                times.append(fleet.t)
                for person, place, robot in zip(self._people, places, fleet.robots, strict=True):
                    person.watch(fleet.t)
                    place.append((robot.rig.body.pose.x, robot.rig.body.pose.y))
        return times, places

    def _blame(self) -> None:
        """Tell contacts that the base alone could have prevented from all others."""
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
            if any(until >= fleet.t for until in self._dead_until):
                self._contacts_blind += new

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
        files = list(self._target.glob("*.mcap"))
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
            recordings_mb=round(sum(path.stat().st_size for path in files) / 1e6, 1),
            recordings=len(files),
            records_lost=sum(recording.lost for recording in self.recordings),
            touched=tuple(touched),
        )


class SoakLog:
    """Keeps what a soak has shown so far in files, hour by hour: a kill loses the last hour only.

    ``path`` gets a JSON line per hour, and beside it ``.summary.json`` the summary of them all.
    """

    def __init__(self, path: Path) -> None:
        """Begin anew; what an earlier run has left there goes."""
        self._path = path
        self._rows: list[SoakHour] = []
        path.write_text("")

    def add(self, row: SoakHour) -> None:
        """Write an hour's row, and the summary up to it."""
        self._rows.append(row)
        with self._path.open("a") as file:
            file.write(json.dumps(dataclasses.asdict(row)) + "\n")
        fresh = self._path.with_suffix(".new")
        fresh.write_text(json.dumps(summary(self._rows), indent=2) + "\n")
        fresh.replace(self._path.with_suffix(".summary.json"))


def summary(rows: list[SoakHour]) -> dict[str, Any]:
    """Return the whole run: its last row, all contacts, slopes over the hours after the first."""
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
    """Return the slope of a line through points by least squares; None for fewer than two."""
    if len(points) < 2:
        return None
    x, y = np.array(points).T
    return round(float(np.polyfit(x, y, 1)[0]), 4)


def _resident_mb() -> float:
    pages = int(_MEMORY.read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20
