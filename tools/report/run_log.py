"""One recording's data for a report, as arrays over agent time."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, TypeVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from drivers.p2os.command_numbers import CommandNumber
from drivers.p2os.commands import decode_command
from drivers.p2os.framing import PacketFramer
from maps.input_limits import BAD_DATA, MAX_DURATION_S
from robot_agent.messages.bounded_fields import Count, Number, Text, Word
from robot_agent.messages.streams import DeviceStatus, LocalizationStatus, PlanarPose, Twist
from robot_agent.recording.run_header import RunHeader
from tools.logs.recording import Recording, read_recording

Floats = NDArray[np.float64]

T = TypeVar("T")

_CHI_SQUARE_95 = 5.991  # 95 % quantile of chi squared with two degrees of freedom


class _Decision(msgspec.Struct):
    """The fields of a decision payload that a report uses."""

    action: Word
    direction: Annotated[int, msgspec.Meta(ge=-1, le=1)]
    distance_from_border: Number
    abscissa: Number
    pose: PlanarPose
    command: Twist
    neighbor: PlanarPose | None = None
    gate_reason: Word = ""
    override: Word = ""
    turn: Word = ""


class _Status(msgspec.Struct):
    """The fields of a status payload that a report uses."""

    health: Text
    base: DeviceStatus
    laser: DeviceStatus
    localization: LocalizationStatus
    battery: Number | None = None


class _Process(msgspec.Struct):
    """The fields of a process payload that a report uses."""

    cpu: Number
    memory_mb: Number
    lateness_median: Number
    lateness_max: Number
    longest_pause: Number = 0.0
    deadline_misses: Count = 0
    recorder_lost: Count = 0
    telemetry_dropped: Count = 0
    operator: bool | None = None


class _Log(msgspec.Struct):
    level: Count
    message: Text
    name: Word


class _Link(msgspec.Struct):
    link: Word
    up: bool
    reason: Text = ""


class _Reference(msgspec.Struct):
    x: Number
    y: Number
    theta: Number


class _Gap(msgspec.Struct):
    lost: Count


@dataclass(frozen=True, slots=True)
class LogLine:
    """One log entry of the agent or its process."""

    t: float
    level: int
    part: str
    message: str


@dataclass(frozen=True, slots=True)
class LinkChange:
    """A port was opened, or lost for a reason."""

    t: float
    link: str
    up: bool
    reason: str


@dataclass(eq=False)
class RunLog:
    """One robot's run. Arrays named ``x_t`` are the times of the arrays that follow them."""

    path: Path
    header: RunHeader
    shift: float = 0.0
    """Team time minus agent time, s."""
    truncated: str | None = None
    unreadable: int = 0
    """Messages left out because they do not fit their stream."""
    end: float = 0.0
    """Agent time of the last message, s."""
    shutdown_at: float | None = None
    """Agent time of the shutdown event, s; None if the recording has none."""

    decision_t: Floats = field(default_factory=lambda: np.empty(0))
    pose: Floats = field(default_factory=lambda: np.empty((0, 3)))
    """(n, 3) map_from_base at each decision, m and rad."""
    action: list[str] = field(default_factory=list)
    direction: NDArray[np.int8] = field(default_factory=lambda: np.empty(0, np.int8))
    distance: Floats = field(default_factory=lambda: np.empty(0))
    """Distance from the border by the pose estimate, (n,), m."""
    abscissa: Floats = field(default_factory=lambda: np.empty(0))
    command: Floats = field(default_factory=lambda: np.empty((0, 2)))
    """(n, 2) m/s and rad/s, after the gate."""
    gate: list[str] = field(default_factory=list)
    """The gate's reason at each decision, empty for none."""
    override: list[str] = field(default_factory=list)
    """The override at each decision, empty for none."""
    turn: list[str] = field(default_factory=list)
    """The cause of a turn at each decision, empty for none."""
    neighbor: Floats = field(default_factory=lambda: np.empty((0, 2)))
    """(n, 2) the nearest teammate in the map, m; nan for none."""

    status_t: Floats = field(default_factory=lambda: np.empty(0))
    status: list[_Status] = field(default_factory=list)
    process_t: Floats = field(default_factory=lambda: np.empty(0))
    process: list[_Process] = field(default_factory=list)
    lines: list[LogLine] = field(default_factory=list)
    links: list[LinkChange] = field(default_factory=list)
    gaps: list[tuple[float, int]] = field(default_factory=list)
    reference_t: Floats = field(default_factory=lambda: np.empty(0))
    reference: Floats = field(default_factory=lambda: np.empty((0, 3)))
    received: dict[str, Floats] = field(default_factory=dict)
    """Times at which bytes were received, by link."""
    tick_t: Floats = field(default_factory=lambda: np.empty(0))
    order_t: Floats = field(default_factory=lambda: np.empty(0))
    moving_order: NDArray[np.bool_] = field(default_factory=lambda: np.empty(0, np.bool_))
    """Whether the commands to the base from ``order_t`` on were to move."""

    @property
    def name(self) -> str:
        """The robot's name."""
        return self.header.robot

    def continues(self, earlier: RunLog) -> bool:
        """Return whether it is of the same run, in a new file after an error of the disk."""
        ours, theirs = self.header, earlier.header
        return bool(ours.boot) and (ours.boot, ours.start_monotonic_ns) == (
            theirs.boot,
            theirs.start_monotonic_ns,
        )

    @property
    def readable_part(self) -> str:
        """How much of the file could be read, in words."""
        if not self.unreadable:
            return self.truncated or "whole"
        return f"{self.truncated or 'whole'}; {self.unreadable} messages do not fit their stream"

    @property
    def ended_in_order(self) -> bool:
        """Whether the agent was shut down, not killed."""
        return self.shutdown_at is not None

    @property
    def is_log(self) -> bool:
        """Whether it was converted from a log, whose robot the agent did not control."""
        return self.header.source not in ("live", "bench")

    def bounds(self) -> Floats:
        """Return the semi-major axis of the position's 95 % ellipse at each status, (n,), m."""
        return np.array([error_bound(status.localization.covariance) for status in self.status])

    def reference_errors(self) -> tuple[Floats, Floats]:
        """Return times (n,), s, and position errors (n,), m, of the poses at the references.

        Empty without references.
        """
        if not self.reference_t.size or self.decision_t.size < 2:
            return np.empty(0), np.empty(0)
        nearest = np.searchsorted(self.decision_t, self.reference_t).clip(
            1, self.decision_t.size - 1
        )
        near = self.decision_t[nearest] - self.reference_t < 0.3
        x, y = (np.interp(self.reference_t, self.decision_t, self.pose[:, axis]) for axis in (0, 1))
        errors = np.hypot(x - self.reference[:, 0], y - self.reference[:, 1])
        inside = (
            near
            & (self.reference_t >= self.decision_t[0])
            & (self.reference_t <= self.decision_t[-1])
        )
        return self.reference_t[inside], errors[inside]


def error_bound(covariance: list[float]) -> float:
    """Return the semi-major axis of the 95 % ellipse of (x, y), m; nan without a covariance.

    covariance: of (x, y, theta), 9 values row by row.
    """
    if len(covariance) != 9:
        return math.nan
    a, b, c = covariance[0], covariance[1], covariance[4]
    largest = (a + c) / 2.0 + math.hypot((a - c) / 2.0, b)
    return math.sqrt(_CHI_SQUARE_95 * max(largest, 0.0))


def read_run(path: Path, progress: Callable[[float], None] = lambda _: None) -> RunLog:
    """Read one recording, up to a truncation, for a report.

    progress: called with the agent time read, s. Raises RecordingError for an unreadable file.
    """
    recording = read_recording(path)
    return _Reader(recording).read(progress)


class _Reader:
    """Reads a recording once, decoding only what a report uses."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._log = RunLog(recording.path, recording.header)
        self._times: dict[str, list[float]] = {}
        self._decisions: list[_Decision] = []
        self._references: list[_Reference] = []
        self._orders: list[tuple[float, bool]] = []
        self._framer = PacketFramer()
        self._v = self._w = 0
        log = self._log
        self._handlers: dict[str, Callable[[float, bytes], object]] = {
            "decision": _appender(_Decision, self._decisions),
            "status": _appender(_Status, log.status),
            "process": _appender(_Process, log.process),
            "reference": _appender(_Reference, self._references),
            "event": self._on_line,
            "process_log": self._on_line,
            "link": self._on_link,
            "gap": lambda t, data: log.gaps.append((t, msgspec.json.decode(data, type=_Gap).lost)),
            "base/tx": self._on_orders,
            "base/rx": lambda _t, _data: None,
            "laser/rx": lambda _t, _data: None,
            "tick": lambda _t, _data: None,
            "shutdown": self._on_end,
        }

    def read(self, progress: Callable[[float], None]) -> RunLog:
        handlers = self._handlers
        times: dict[str, list[float]] = {topic: [] for topic in handlers}
        t, cut = 0.0, None
        for topic, at, data in self._recording.messages(handlers.keys()):
            if at > MAX_DURATION_S:
                cut = (
                    f"{self._log.path}: a report holds {MAX_DURATION_S:.0f} s, not up to {at:.0f} s"
                )
                break
            t = at
            try:
                handlers[topic](t, data)
            except BAD_DATA:
                self._log.unreadable += 1
                continue
            times[topic].append(t)
            if topic == "status":
                progress(t)
        self._times = times
        self._log.end = t
        self._log.truncated = cut or self._recording.truncated
        self._fill_arrays()
        return self._log

    def _fill_arrays(self) -> None:
        """Convert the collected messages to arrays."""
        log, decisions = self._log, self._decisions
        log.decision_t = self._array("decision")
        log.pose = _table([(d.pose.x, d.pose.y, d.pose.theta) for d in decisions], 3)
        log.action = [d.action for d in decisions]
        log.direction = np.array([d.direction for d in decisions], np.int8)
        log.distance = np.array([d.distance_from_border for d in decisions])
        log.abscissa = np.array([d.abscissa for d in decisions])
        log.command = _table([(d.command.v, d.command.w) for d in decisions], 2)
        log.gate = [d.gate_reason for d in decisions]
        log.override = [d.override for d in decisions]
        log.turn = [d.turn for d in decisions]
        nothing = (math.nan, math.nan)
        log.neighbor = _table(
            [nothing if d.neighbor is None else (d.neighbor.x, d.neighbor.y) for d in decisions], 2
        )
        log.status_t = self._array("status")
        log.process_t = self._array("process")
        log.reference_t = self._array("reference")
        log.reference = _table([(r.x, r.y, r.theta) for r in self._references], 3)
        log.received = {link: self._array(f"{link}/rx") for link in ("base", "laser")}
        log.tick_t = self._array("tick")
        log.order_t = np.array([t for t, _moving in self._orders])
        log.moving_order = np.array([moving for _t, moving in self._orders], np.bool_)

    def _array(self, topic: str) -> Floats:
        return np.array(self._times[topic], dtype=np.float64)

    def _on_line(self, t: float, data: bytes) -> None:
        line = msgspec.json.decode(data, type=_Log)
        self._log.lines.append(LogLine(t, line.level, line.name, line.message))

    def _on_link(self, t: float, data: bytes) -> None:
        change = msgspec.json.decode(data, type=_Link)
        self._log.links.append(LinkChange(t, change.link, change.up, change.reason))

    def _on_end(self, t: float, _data: bytes) -> None:
        self._log.shutdown_at = t

    def _on_orders(self, t: float, data: bytes) -> None:
        """Note changes between commands to move and to stand in bytes sent to the base."""
        for packet in self._framer.feed(data):
            command = decode_command(packet)
            number, value = command.number, command.integer
            if number == CommandNumber.VEL:
                self._v = value
            elif number == CommandNumber.RVEL:
                self._w = value
            elif number in _STANDING or (number == CommandNumber.ENABLE and not value):
                self._v = self._w = 0
            else:
                continue
            moving = bool(self._v or self._w)
            if not self._orders or self._orders[-1][1] != moving:
                self._orders.append((t, moving))


_STANDING = frozenset((CommandNumber.STOP, CommandNumber.E_STOP, CommandNumber.CLOSE))


def _appender(shape: type[T], target: list[T]) -> Callable[[float, bytes], object]:
    decode = msgspec.json.Decoder(shape).decode
    return lambda _t, data: target.append(decode(data))


def _table(rows: list[tuple[float, ...]], width: int) -> Floats:
    return np.array(rows, dtype=np.float64).reshape(-1, width)
