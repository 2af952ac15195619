"""A day of robots that come and go at a monitor, as fast as it goes.

The telemetry is that of an agent in the bench; each robot plays it again and again under its own
name, with time stamps of its own.
"""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

from maps.map_folder import load_map_folder
from robot_agent.config import AgentConfig, find_map
from robot_agent.messages.effects import Effect, Publish
from robot_agent.messages.events import Event
from tools.bench.bench_fault import parse_fault
from tools.bench.fleet import Fleet
from tools.campaign.footprint import Footprint, footprint_of
from tools.monitor.page_message import PageFeed
from tools.monitor.shift_log import ShiftLog
from tools.monitor.site import load_site
from tools.monitor.team_state import TeamState
from tools.monitor.watch import Watch

CYCLE_S = 600
"""Time of the day in a cycle, s."""
_START = 1_800_000_000
"""Time at which the day begins, s since 1970."""
_TOGETHER = 6
"""Robots at a time."""
_STAY_S = 1800
"""Time after which a robot goes and another one comes; one of them every five minutes."""
_FAULT = "robot1:blind@30-40"
_PAGE_S = 5
_PARTICLES_S = 10
_SECOND = re.compile(rb'"sec":(\d+)')

Tape = list[list[tuple[str, bytes]]]
"""Streams and payloads of each second."""


def watch_day(cycles: int) -> Iterator[Footprint]:
    """Give a monitor's team, alarms, shift log and page ``cycles`` times ten minutes of a day."""
    yield from play_day(record_tape(), cycles)


def play_day(tape: Tape, cycles: int) -> Iterator[Footprint]:
    """Do what ``watch_day`` does with a tape."""
    team = TeamState()
    with tempfile.TemporaryDirectory() as folder, closing(ShiftLog(Path(folder, "log"))) as log:
        watch = Watch(team, load_site(find_map("paper_lab", Path())), on_alarm=log.put)
        feed = PageFeed(watch)
        for cycle in range(cycles):
            for second in range(cycle * CYCLE_S, (cycle + 1) * CYCLE_S):
                _one_second(team, tape, second)
                watch.advance(float(second), float(_START + second))
                if second % _PAGE_S == 0:
                    feed.message({})
            yield footprint_of(os.getpid())


def _one_second(team: TeamState, tape: Tape, second: int) -> None:
    """Let all robots of this second report; those whose time is over go, others come."""
    t, wall = float(second), float(_START + second)
    for place in range(_TOGETHER):
        stay, since = divmod(second + place * _STAY_S // _TOGETHER, _STAY_S)
        key = f"patrol/lab/robot{place}-{stay}"
        if since == 0:
            before = f"patrol/lab/robot{place}-{stay - 1}"
            team.set_liveliness(before, online=False, t=t)
            team.set_liveliness(key, online=True, t=t)
        for stream, payload in tape[since % len(tape)]:
            team.receive(f"{key}/{stream}", _stamped(payload, second), t, wall)


def _stamped(payload: bytes, second: int) -> bytes:
    """Return a payload with the time stamps of a second of the day, for those of the tape."""
    return _SECOND.sub(b'"sec":%d' % (_START + second), payload)


def record_tape(seconds: int = 60) -> Tape:
    """Return what a robot publishes on patrol, whose laser is silent for ten seconds from 30 s on.

    Of each stream the last payload of each second, of log messages all, of particles, which take
    as long as all others together, few.
    """
    taker = _Taker(seconds)
    fleet = Fleet(
        load_map_folder(find_map("paper_lab", Path())),
        1,
        seed=1,
        observer=taker.of,
        faults=[parse_fault(_FAULT)],
        strangers=4,
    )
    while fleet.t < seconds:
        fleet.step()
    return [list(second.values()) for second in taker.seconds]


class _Taker:
    """Takes what an agent publishes."""

    def __init__(self, seconds: int) -> None:
        self.seconds: list[dict[str, tuple[str, bytes]]] = [{} for _ in range(seconds)]

    def of(self, _name: str, _config: AgentConfig) -> _Taker:
        """Return itself, as the observer of the only robot."""
        return self

    def record_event(self, event: Event) -> None:
        """Ignore what the robot gets."""

    def record_effect(self, t: float, effect: Effect) -> None:
        """Keep a payload; a later one of the same second replaces it."""
        if isinstance(effect, Publish) and t < len(self.seconds):
            if effect.stream == "particles" and int(t) % _PARTICLES_S:
                return
            second = self.seconds[int(t)]
            name = f"event {len(second)}" if effect.stream == "event" else effect.stream
            second[name] = (effect.stream, effect.payload)
