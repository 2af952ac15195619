"""Feeds a recording's events to a new agent and compares its effects with the recorded ones."""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import msgspec
import numpy as np

from maps.map_folder import MapFolder, map_folder_from_files
from maps.occupancy_map import Surface
from maps.pose import Pose
from robot_agent.agent import Agent
from robot_agent.config import AgentConfig
from robot_agent.messages.effects import Effect, Publish, Send
from robot_agent.messages.events import Event
from robot_agent.perception.silhouette import BODY
from robot_agent.recording.arithmetic import arithmetic, processor
from robot_agent.recording.recording_writer import Gap, Note, Reference
from robot_agent.recording.run_header import same_arithmetic, same_versions, versions
from tools.logs.recorded_config import recorded_config
from tools.logs.recording import Recording
from tools.replay.comparison import same_effects
from tools.replay.what_if import ANOTHER_COMMAND, WhatIf

SHOWN = 200
"""Most characters of a differing effect that are printed."""


@dataclass(frozen=True, eq=False)
class Step:
    """One recorded event with its recorded effects."""

    event: Event
    effects: list[Effect]
    complete: bool
    """False for the last event of a file: its effects may be truncated."""


@dataclass
class ReplayResult:
    """Counts and comparison of a replay."""

    events: int = 0
    decisions: int = 0
    bytes_sent: int = 0
    duration: float = 0.0
    """Recorded duration replayed, s."""
    wall: float = 0.0
    """Real time of the replay, s."""
    actions: Counter[str] = field(default_factory=Counter)
    """Control steps in each action."""
    health: Counter[str] = field(default_factory=Counter)
    """Scans at each localization health."""
    position_errors: list[float] = field(default_factory=list)
    """Distance from the recording's reference pose at each scan that has one, m."""
    difference: str | None = None
    """Description of the first differing effect; None while all are identical."""
    records_lost: bool = False
    """Whether it ended where the recorder lost records."""


_FACES_SINCE_LAYOUT = 3
"""The programs of earlier layouts took every wall's surface to be in the middle of its cells."""
_SILHOUETTES_SINCE_LAYOUT = 4
"""The programs of earlier layouts knew teammates by the rectangle of their own body alone."""


class Replay:
    """One recording, ready for replay."""

    def __init__(
        self,
        recording: Recording,
        folder: MapFolder | None = None,
        config: AgentConfig | None = None,
    ) -> None:
        """Build the agent of the recording; ``folder`` and ``config`` replace those recorded.

        Raises:
            ConfigError, MapError, BorderError: configuration, map or border are invalid.
        """
        header = recording.header
        self.left_out: list[str] = []
        """Recorded settings that are obsolete in this program."""
        if config is None:
            config, self.left_out = recorded_config(recording)
            if recording.layout < _SILHOUETTES_SINCE_LAYOUT:
                alone = msgspec.structs.replace(config.perception, silhouettes=(BODY,))
                config = msgspec.structs.replace(config, perception=alone)
        if folder is None:
            name = Path(config.map.folder).name
            folder = map_folder_from_files(name, header.map_files, config.map.border)
            if recording.layout < _FACES_SINCE_LAYOUT:
                folder = replace(folder, map=replace(folder.map, surface=Surface.CENTRE))
        self._recording = recording
        self._agent = Agent(config, folder, header.start_wall_ns)
        self._references: dict[int, Pose] = {}
        self._last_estimate_t: float | None = None

    def run(
        self,
        until: float | None = None,
        progress: Callable[[float], None] = lambda _: None,
        *,
        check: bool = True,
        since: float = 0.0,
        what_if: WhatIf | None = None,
        against: Replay | None = None,
    ) -> ReplayResult:
        """Replay up to agent time ``until``, or to the first difference when checking.

        Events before ``since`` are replayed, because the agent's state depends on them, but neither
        compared nor counted. ``what_if`` receives all decisions after it, with those of ``against``
        on the same events, or those recorded; with it, checking goes on after a difference.
        """
        result = ReplayResult()
        started = time.perf_counter()
        first_t: float | None = None
        for step in self._steps(result):
            t = step.event.t
            if until is not None and t > until:
                break
            first_t = t if first_t is None else first_t
            effects = self._agent.handle(step.event)
            before = step.effects if against is None else against._agent.handle(step.event)
            result.duration = t - first_t
            progress(t)
            if t < since:
                continue
            self._count(result, effects)
            if what_if is not None and step.complete:
                what_if.compare(t, before, effects)
            if not check or result.difference is not None:
                continue
            if not same_effects(
                step.effects, effects, self._recording.layout, complete=step.complete
            ):
                result.difference = _describe(step, effects)
                if what_if is None:
                    break
        result.wall = time.perf_counter() - started
        return result

    def _steps(self, result: ReplayResult) -> Iterator[Step]:
        """Group the recording's items: each event with its effects."""
        event: Event | None = None
        effects: list[Effect] = []
        for item in self._recording.items():
            if isinstance(item, Effect):
                effects.append(item)
                continue
            if isinstance(item, Note):
                continue
            if isinstance(item, Reference):
                self._references[_milliseconds(item.t)] = item.pose
                continue
            if event is not None:
                yield Step(event, effects, complete=not isinstance(item, Gap))
            if isinstance(item, Gap):
                result.records_lost = True
                result.difference = (
                    f"the recorder lost {item.lost} records at {item.t:.6f} s: "
                    "a replay cannot go past that"
                )
                return
            event, effects = item, []
        if event is not None:
            yield Step(event, effects, complete=False)

    def _count(self, result: ReplayResult, effects: list[Effect]) -> None:
        result.events += 1
        for effect in effects:
            if isinstance(effect, Send):
                result.bytes_sent += len(effect.data)
            elif isinstance(effect, Publish) and effect.stream == "decision":
                result.decisions += 1
                assert self._agent.decision is not None
                result.actions[self._agent.decision.action] += 1
        self._compare_with_reference(result)

    def _compare_with_reference(self, result: ReplayResult) -> None:
        """Count a new estimate's health and store its error if the recording has a reference."""
        estimate = self._agent.localizer.estimate
        if estimate is None or estimate.t == self._last_estimate_t:
            return
        self._last_estimate_t = estimate.t
        result.health[estimate.health] += 1
        reference = self._reference_at(estimate.t)
        if reference is not None:
            error = math.hypot(estimate.pose.x - reference.x, estimate.pose.y - reference.y)
            result.position_errors.append(error)

    def _reference_at(self, t: float) -> Pose | None:
        """Return the reference within a few ms of t, None if there is none."""
        middle = _milliseconds(t)
        for offset in sorted(range(-5, 6), key=abs):
            if middle + offset in self._references:
                return self._references[middle + offset]
        return None


def _milliseconds(t: float) -> int:
    return round(t * 1000)


def _describe(step: Step, effects: list[Effect]) -> str:
    """Return the first differing effect, recorded and now, with its event, for people."""
    pairs = zip(step.effects, effects, strict=False)
    index = next((i for i, (a, b) in enumerate(pairs) if a != b), None)
    if index is None:
        index = min(len(step.effects), len(effects))
    recorded = step.effects[index] if index < len(step.effects) else "nothing"
    now = effects[index] if index < len(effects) else "nothing"
    return (
        f"different at {step.event.t:.6f} s, on {_shorten(step.event)}:\n"
        f"  recorded: {_shorten(recorded)}\n"
        f"  now:      {_shorten(now)}"
    )


def _shorten(value: object) -> str:
    text = repr(value)
    return text if len(text) <= SHOWN else f"{text[:SHOWN]}..."


def notices(replay: Replay, recording: Recording) -> list[str]:
    """Return the differences in program and settings between replay and run, one line each."""
    lines = [f"layout {step}" for step in recording.upgrades]
    if replay.left_out:
        lines.append(f"settings that exist no more are left out: {', '.join(replay.left_out)}")
    header = recording.header
    if not same_versions(header.versions):
        lines.append(f"recorded with {header.versions}; this is {versions()}")
    if header.arithmetic and header.arithmetic != arithmetic():
        lines.append(
            f"recorded on {header.processor or 'another computer'} ({header.arithmetic}); "
            f"this is {processor() or 'another'} ({arithmetic()})"
        )
    if not same_arithmetic(header):
        lines.append(
            f"numbers may differ: a check is by decisions, with commands within {ANOTHER_COMMAND} "
            "m/s and rad/s"
        )
    return lines


def report_lines(result: ReplayResult) -> list[str]:
    """Return the result of a replay in lines for people."""
    rate = result.duration / result.wall if result.wall else math.inf
    lines = [
        f"{result.events} events, {result.decisions} decisions, {result.bytes_sent} bytes sent",
        f"{result.duration:.1f} s replayed in {result.wall:.1f} s: {rate:.0f} x real time",
    ]
    if result.actions:
        lines.append(f"control steps: {_shares(result.actions).replace('_', ' ')}")
    if result.health:
        lines.append(f"scans: {_shares(result.health)}")
    if result.position_errors:
        errors = np.array(result.position_errors)
        lines.append(
            f"position error against the reference, {errors.size} scans (m): "
            f"median {np.median(errors):.3f}, p95 {np.percentile(errors, 95):.3f}, "
            f"max {errors.max():.3f}"
        )
    return lines


def _shares(counts: Counter[str]) -> str:
    return ", ".join(f"{name} {count}" for name, count in counts.most_common())
