"""What happens in a device's session, told once each: what it waits for, its troubles, its faults.

A session knows all of it but speaks to nobody; this turns it into notices with their remedies and
into counters for the status.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from drivers.scanner import Framer
from robot_agent.messages.events import LinkName
from robot_agent.messages.log_level import LogLevel
from robot_agent.messages.notice import Notice

PATIENCE_S = 3.0
"""s in one step of a session after which it is told; most take less than a second."""
PERIOD_S = 0.2
"""s between two looks at a session."""

PROGRESS = frozenset({"sips", "commands", "scans"})
"""Counters that grow while all is well."""
COUNTED: Mapping[LinkName, Mapping[str, str]] = {
    "base": {
        "old_sessions": "was in the session of another client, which was closed",
        "resumptions": "was found in its old session, which goes on",
        "cut_packets": "sends packets too short for their type: `patrol doctor` shows its firmware",
        "other_packets": "sends packets of an unknown type, which are left out",
        "unknown_sonars": "reports sonars that its model lacks: is base.model the robot's?",
        "stale_requests": "got no speeds in time and was stopped: this computer is overloaded",
        "bad_checksum": "sends garbled packets: look at cable and plugs, off the motors",
    },
    "laser": {
        "unusable": "sends values that are no whole scan: end its other clients",
        "timeouts": "answers late or not at all and is asked again",
        "refusals": "refused a command or a setting",
        "naks": "did not understand a telegram (NAK): look at its cable",
        "variant_writes": "had another field of view or step, which was set",
        "configuration_writes": "had another configuration, which was written to it",
        "bad_checksum": "sends garbled telegrams: look at cable and plugs, off the motors",
    },
}
"""Words for the first time that a counter of a session or of its line has grown.

Those without words are also told as troubles: silences, searches, resets of the controller.
"""
_LONG_WAYS: Mapping[str, str] = {
    "writing configuration": "; do not switch it off, it writes to its EEPROM",
    "setting variant": "; do not switch it off, it may write to its EEPROM",
}


class DeviceSession(Protocol):
    """Common interface of the sessions with base and laser."""

    @property
    def state(self) -> str:
        """Step of the session."""

    @property
    def trouble(self) -> str | None:
        """A line with the present trouble and its remedy; None if there is none."""

    @property
    def manner(self) -> str:
        """How the device is spoken to, for people: at which rate, in which dialect."""

    @property
    def counters(self) -> Any:
        """Counts since the start, a dataclass."""

    @property
    def framer(self) -> Framer:
        """The line's framer."""


@dataclass(slots=True)
class _Told:
    """What was told of a session so far: its state, since when, s, and counters that had grown."""

    state: str
    since: float = 0.0
    counters: frozenset[str] = frozenset()


class DeviceWatch:
    """Watches one device's session."""

    def __init__(self, link: LinkName, serving: str, down: str) -> None:
        """Watch the session of a link; serving, down: names of its state when all is well, and
        without a port, of which the link's own notices tell."""
        self._link = link
        self._serving = serving
        self._down = down
        self._told = _Told(state=down)
        self._bad_before = 0
        self._next = 0.0

    def notices(self, t: float, session: DeviceSession, name: str | None) -> Iterator[Notice]:
        """Return what is new at t; name: of the device, None while unknown."""
        if t < self._next:
            return
        self._next = t + PERIOD_S
        yield from self._of_state(t, session, name)
        yield from self._of_counters(t, session)

    def counters(self, session: DeviceSession) -> dict[str, int]:
        """Return the counters that tell of anything, by name; those at 0 are left out."""
        source = session.counters  # read field by field: asdict copies, at each of many ticks
        counted = {
            name: n
            for name in source.__dataclass_fields__
            if name not in PROGRESS and (n := getattr(source, name))
        }
        if session.framer.counters.bad_checksum:
            counted["bad_checksum"] = session.framer.counters.bad_checksum
        if "searches" in counted:  # the first is how it begins
            counted["searches"] -= 1
        return {name: n for name, n in counted.items() if n}

    def _of_state(self, t: float, session: DeviceSession, name: str | None) -> Iterator[Notice]:
        told, state, trouble = self._told, str(session.state), session.trouble
        if state != told.state:
            if state == self._serving:
                self._bad_before = session.framer.counters.bad_checksum
            told.state, told.since = state, t
        if state == self._down:
            return
        serving = state == self._serving
        if trouble is not None:
            level = LogLevel.WARNING if serving else LogLevel.ERROR
            yield Notice(t, self._link, trouble, level)
        elif serving:
            yield Notice(
                t, self._link, f"{state}: {name or 'unnamed'} {session.manner}", LogLevel.INFO
            )
        elif t - told.since >= PATIENCE_S:
            words = f"still {state}{_LONG_WAYS.get(state, '')}"
            yield Notice(t, self._link, words, LogLevel.INFO)

    def _of_counters(self, t: float, session: DeviceSession) -> Iterator[Notice]:
        """Tell of each counter once; garbled frames while the rate is searched for are none."""
        grown = self.counters(session)
        if grown.get("bad_checksum", 0) <= self._bad_before:
            grown.pop("bad_checksum", None)
        for counter in sorted(grown.keys() - self._told.counters):
            words = COUNTED[self._link].get(counter)
            if words is not None:
                yield Notice(t, f"{self._link}.{counter}", words, LogLevel.INFO)
        self._told.counters |= grown.keys()
