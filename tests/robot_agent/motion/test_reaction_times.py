"""Delay from a fault at any time in the cycle to the agent's stop command, in events' time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.lms200.framing import REPLY_BIT, encode_telegram
from drivers.lms200.measurement import MEASURING_MODES, MODE_32_M, UNIT_MM
from drivers.lms200.settings import LaserSettings
from drivers.p2os.command_numbers import CommandNumber
from drivers.p2os.commands import decode_command
from drivers.p2os.framing import PacketFramer
from maps.map_folder import MapFolder, load_map_folder
from maps.pose import Pose
from robot_agent.agent import Agent
from robot_agent.config import find_map
from robot_agent.messages.effects import Effect, Send
from robot_agent.messages.events import BytesReceived, Event, LinkDown, LinkName
from tests.drivers.lms200.measured_telegram import encode_measurement
from tools.bench.fleet import Fleet

DRIVING_S = 15.0
LIMIT_S = 0.3
PHASES = [0.013 * step for step in range(9)]
"""s after DRIVING_S: all over a report's and a scan's period."""


class Tape:
    """Records the events of an agent."""

    def __init__(self) -> None:
        self.events: list[Event] = []

    def record_event(self, event: Event) -> None:
        self.events.append(event)

    def record_effect(self, t: float, effect: Effect) -> None:
        """Effects do not matter here."""


@pytest.fixture(scope="module")
def folder() -> MapFolder:
    return load_map_folder(find_map("paper_lab", Path()))


@pytest.fixture(scope="module")
def drive(folder: MapFolder) -> tuple[Fleet, list[Event]]:
    """A robot that drives along the border, and the events of its agent."""
    tape = Tape()
    start = Pose(5.0, 13.4, 0.3)
    fleet = Fleet(folder, 1, seed=5, starts=[start], observer=lambda *_: tape)
    while fleet.t < DRIVING_S + 1.0:
        fleet.step()
    assert fleet.robots[0].rig.base.velocity[0] > 0.3
    return fleet, tape.events


def silent(events: list[Event], link: LinkName, since: float) -> Iterator[Event]:
    for event in events:
        if event.t < since or not (isinstance(event, BytesReceived) and event.link == link):
            yield event


def stuck(events: list[Event], link: LinkName, since: float) -> Iterator[Event]:
    last = b""
    for event in events:
        if not (isinstance(event, BytesReceived) and event.link == link):
            yield event
        elif event.t < since:
            last = event.data
            yield event
        else:
            yield replace(event, data=last)


def blind(events: list[Event], link: LinkName, since: float) -> Iterator[Event]:
    """No beam returns: of what is measured from then on, so a scan's time on the line later."""
    nothing = encode_measurement(np.full(181, np.inf), MEASURING_MODES[MODE_32_M], UNIT_MM)
    telegram = encode_telegram(nothing, REPLY_BIT)
    for event in events:
        measured = event.t - LaserSettings().scan_period
        if isinstance(event, BytesReceived) and event.link == link and measured >= since:
            yield replace(event, data=telegram)
        else:
            yield event


def unplugged(events: list[Event], link: LinkName, since: float) -> Iterator[Event]:
    told = False
    for event in silent(events, link, since):
        if event.t >= since and not told:
            told = True
            yield LinkDown(since, link, "unplugged")
        yield event


def standing_order(agent: Agent, events: Iterator[Event], since: float) -> float | None:
    """Return the time, s, from ``since`` to the last command VEL 0 and RVEL 0."""
    framer = PacketFramer()
    told = {CommandNumber.VEL: 0, CommandNumber.RVEL: 0}
    for event in events:
        for effect in agent.handle(event):
            if isinstance(effect, Send) and effect.link == "base":
                for command in map(decode_command, framer.feed(effect.data)):
                    if command.number in told:
                        told[CommandNumber(command.number)] = command.integer or 0
        if event.t >= since and not any(told.values()):
            return event.t - since
    return None


@pytest.mark.parametrize("phase", PHASES, ids=lambda phase: f"{1e3 * phase:.0f}ms")
@pytest.mark.parametrize(
    ("fault", "link"),
    [
        *((silent, "base"), (stuck, "base")),
        *((silent, "laser"), (stuck, "laser"), (blind, "laser"), (unplugged, "laser")),
    ],
    ids=lambda value: value if isinstance(value, str) else value.__name__,
)
def test_stop_is_sent_in_time_after_data_cease(folder, drive, fault, link, phase):
    fleet, events = drive
    since = DRIVING_S + phase
    agent = Agent(fleet.robots[0].agent.config, folder, publishes=False)
    ordered = standing_order(agent, fault(events, link, since), since)
    assert ordered is not None
    assert 0.0 < ordered <= LIMIT_S


def test_one_lost_report_or_scan_does_not_stop_the_robot(folder, drive):
    fleet, events = drive
    for link in ("base", "laser"):
        lost = next(
            e for e in events if isinstance(e, BytesReceived) and e.link == link and e.t > DRIVING_S
        )
        agent = Agent(fleet.robots[0].agent.config, folder, publishes=False)
        rest = (event for event in events if event is not lost)
        assert standing_order(agent, rest, DRIVING_S) is None
