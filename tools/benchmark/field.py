"""Start time, end time, memory and lateness of the agent, also with a fifth of a core."""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path

from robot_agent.messages.effects import Publish
from robot_agent.messages.events import Shutdown
from robot_agent.messages.streams import ProcessPayload, decode
from tools.benchmark.figure import MEASURED_S, SEED, SETTLED_S, Figure
from tools.campaign.agent_stage import AgentStage
from tools.campaign.cpu_limit import CpuLimit, CpuLimitError
from tools.logs.recording import Recording, read_recording

SLOW = 0.2
"""CPU quota that emulates a slow computer: share of one core of this machine."""
START_LIMIT_S, SLOW_START_LIMIT_S = 3.0, 5.0
END_LIMIT_S = 2.0
MEMORY_LIMIT_MB, CAMERA_MEMORY_LIMIT_MB = 110.0, 130.0


def field(_folder_path: Path) -> Iterator[Figure]:
    """Start the agent, let it patrol and end it by SIGTERM: with a core, a camera, then ``SLOW``.

    Where no CPU quota can be set the slow computer yields one figure: NaN, its limit missed.
    """
    yield from _run("", None)
    yield _memory_with_camera()
    try:
        with closing(CpuLimit(SLOW)) as limit:
            yield from _run(f"{100 * SLOW:g} % of a core: ", limit)
    except CpuLimitError as error:
        yield Figure(f"{100 * SLOW:g} % of a core: {error}", math.nan, "", 0.0)


def _run(where: str, limit: CpuLimit | None) -> Iterator[Figure]:
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        stage = stack.enter_context(closing(AgentStage(folder, SEED)))
        started = time.monotonic()
        stage.start_agent(limit)
        while stage.step().t < started + SETTLED_S + MEASURED_S:
            pass
        moved = stage.trace[-1].moving
        signalled = time.monotonic()
        stage.end_agent()
        ended = stage.ends[-1]
        stands = stage.tap.is_standing and not stage.rig.base.motion_permitted
        recording = read_recording(stage.recordings[0])
        first = _first_decision(recording) - started
        reports = _process_reports(recording)
        whole = any(isinstance(item, Shutdown) for item in recording.items())
        off_border = max(stage.off_border, 0.0)
    settled = [report for t, report in reports if t > started + SETTLED_S]
    limit_s = START_LIMIT_S if limit is None else SLOW_START_LIMIT_S
    yield Figure(f"{where}start to first decision", first, "s", limit_s)
    yield Figure(f"{where}SIGTERM to the process's end", ended - signalled, "s", END_LIMIT_S)
    yield Figure(f"{where}robot moved, then stood", float(moved and stands), "", 1.0, at_least=True)
    yield Figure(f"{where}recording ends with the end", float(whole), "", 1.0, at_least=True)
    memory = max(report.memory_mb for _, report in reports)
    yield Figure(f"{where}memory", memory, "MB", MEMORY_LIMIT_MB)
    share = sum(report.cpu for report in settled) / len(settled)
    yield Figure(f"{where}share of one core used", 100 * share, "%", speed=True)
    events = sum(report.events for report in settled)
    missed = sum(report.deadline_misses for report in settled)
    yield Figure(f"{where}events later than 0.05 s, of {events}", missed, "", 0.0)
    latest = max(report.lateness_max for report in settled)
    yield Figure(f"{where}latest event", 1e3 * latest, "ms")
    yield Figure(f"{where}from border at the end", off_border, "m", 0.1)


def _memory_with_camera() -> Figure:
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        stage = stack.enter_context(closing(AgentStage(folder, SEED)))
        stage.mount_camera()
        started = time.monotonic()
        stage.start_agent()
        while stage.step().t < started + SETTLED_S + MEASURED_S:
            pass
        stage.end_agent()
        reports = _process_reports(read_recording(stage.recordings[0]))
    memory = max(report.memory_mb for _, report in reports)
    return Figure("with a camera: memory", memory, "MB", CAMERA_MEMORY_LIMIT_MB)


def _first_decision(recording: Recording) -> float:
    """Return the monotonic time of the first decision, s; infinite if there is none."""
    t = math.inf
    for item in recording.items():
        if isinstance(item, Publish) and item.stream == "decision":
            return 1e-9 * recording.header.start_monotonic_ns + t
        t = getattr(item, "t", t)
    return math.inf


def _process_reports(recording: Recording) -> list[tuple[float, ProcessPayload]]:
    """Return the recorded process reports with their monotonic times, s."""
    start = 1e-9 * recording.header.start_monotonic_ns
    reports = []
    for _, t, payload in recording.messages(("process",)):
        report = decode("process", payload)
        assert isinstance(report, ProcessPayload)
        reports.append((start + t, report))
    return reports
