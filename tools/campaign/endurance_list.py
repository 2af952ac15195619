"""The trials of endurance: what is done again and again."""

from __future__ import annotations

import os
import resource
import signal
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing
from functools import partial
from pathlib import Path

from drivers.link import Link
from robot_agent.config import TelemetrySettings
from robot_agent.process.telemetry import Telemetry
from tools.campaign.agent_stage import AgentStage
from tools.campaign.chosen import chosen
from tools.campaign.clock_jumps import jump_clocks
from tools.campaign.clock_party import POSE
from tools.campaign.endurance import EnduranceError, Trial
from tools.campaign.footprint import Footprint, footprint_of
from tools.campaign.monitored_day import watch_day
from tools.logs.recording import RecordingError, read_recording
from tools.monitor.endpoint import free_endpoint
from tools.monitor.monitor import Monitor, MonitorOptions
from tools.monitor.site import Site
from tools.simulation.cable import Cable

_PATIENCE_S = 20.0
_LOOK_S = 0.01
_START_S = 6.0
"""From an agent's start until its robot patrols, s."""
_LATELY_S = 2.0


def _unplug(cycles: int) -> Iterator[Footprint]:
    """Unplug and plug in the cable of a driver's link."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        stage = stack.enter_context(closing(AgentStage(folder)))
        cable = Cable(stage.tap, folder / "port")
        stack.callback(cable.pull)
        seen = _Seen()
        link = Link(str(cable.path), 9600, seen, time.monotonic)
        link.start()
        stack.callback(link.close)
        for cycle in range(cycles):
            _wait(partial(seen.more_ups_than, cycle), "the port was not opened again")
            downs = seen.downs
            cable.pull()
            _wait(partial(seen.more_downs_than, downs), "the port's loss was not seen")
            cable.put_back()
            yield footprint_of(os.getpid())


class _Seen:
    """Counts a link's ups and downs."""

    def __init__(self) -> None:
        self.ups = self.downs = 0

    def more_ups_than(self, count: int) -> bool:
        """Whether the port was opened more often."""
        return self.ups > count

    def more_downs_than(self, count: int) -> bool:
        """Whether the port was lost, or could not be opened, more often."""
        return self.downs > count

    def received(self, t: float, data: bytes) -> None:
        """Bytes arrived."""

    def link_up(self, t: float) -> None:  # noqa: ARG002 - as LinkListener has it
        """The port was opened."""
        self.ups += 1

    def link_down(self, t: float, reason: str) -> None:  # noqa: ARG002 - as LinkListener has it
        """The port was lost."""
        self.downs += 1


def _come_and_go(cycles: int) -> Iterator[Footprint]:
    """Let robots come to a monitor and go, each under another name."""
    endpoint = free_endpoint()
    settings = TelemetrySettings(operator=endpoint)
    with closing(Monitor(MonitorOptions(endpoint, None, Site(None)))) as monitor:
        for cycle in range(cycles):
            name = f"robot{cycle}"
            with closing(Telemetry(settings, robot=name, team="lab")) as robot:
                _wait(partial(_is_shown, monitor, robot, f"lab/{name}"), f"{name} was not shown")
            yield footprint_of(os.getpid())


def _is_shown(monitor: Monitor, robot: Telemetry, name: str) -> bool:
    """Let a robot report; return whether it is shown as online with its pose."""
    robot.publish("pose", POSE)
    shown = {each.id: each for each in monitor.operator.team.snapshot()}
    return name in shown and shown[name].online and bool(shown[name].poses)


def _fill_disk(cycles: int) -> Iterator[Footprint]:
    """Let the disk of a patrolling robot be full, and have room again."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        stage = stack.enter_context(closing(AgentStage(folder)))
        stage.start_agent()
        _step(stage, _START_S)
        for _ in range(cycles):
            written = sum(path.stat().st_size for path in folder.glob("*.mcap"))
            stage.limit_agent(resource.RLIMIT_FSIZE, min(written, 1000))
            _step(stage, 2.0)
            stage.limit_agent(resource.RLIMIT_FSIZE, resource.RLIM_INFINITY)
            _step(stage, 3.0)
            _require_patrol(stage)
            yield footprint_of(stage.agent_pid)
        stage.end_agent()
        for path in folder.glob("*.mcap"):
            _require_readable(path)


def _kill_starts(cycles: int) -> Iterator[Footprint]:
    """Kill agents at ever later points of their start; the last one must find all in order."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        stage = stack.enter_context(closing(AgentStage(folder)))
        stage.pose_file = folder / "pose.json"
        for cycle in range(cycles):
            stage.start_agent()
            _step(stage, _START_S * cycle / cycles / 2.0)
            stage.signal_agent(signal.SIGKILL)
            yield footprint_of(os.getpid())
        stage.start_agent()
        _step(stage, _START_S)
        _require_patrol(stage)
        stage.end_agent()
        for path in folder.glob("*.mcap"):
            _require_readable(path)


TRIALS: tuple[Trial, ...] = (
    Trial("replug", "driver's cable unplugged and plugged in", 1000, _unplug),
    Trial("come-and-go", "robots of new names come to a monitor and go", 300, _come_and_go),
    Trial("disk-full", "disk of a patrolling robot full, and back", 20, _fill_disk),
    Trial("kill-starts", "agent killed at points of its start", 50, _kill_starts),
    Trial(
        "clock-jumps",
        "clock set 20 years ahead or 30 back under TLS, and back",
        60,
        jump_clocks,
    ),
    Trial("monitored-day", "ten minutes of robots that come and go at a monitor", 144, watch_day),
)


def chosen_trials(names: Sequence[str]) -> list[Trial]:
    """Return the trials of these names, all if ``names`` is empty; raises EnduranceError."""
    return chosen(
        TRIALS,
        names,
        lambda name, known: EnduranceError(f"no trial {name!r}; trials are {known}"),
    )


def _wait(true: Callable[[], bool], trouble: str) -> None:
    give_up = time.monotonic() + _PATIENCE_S
    while not true():
        if time.monotonic() > give_up:
            raise EnduranceError(trouble)
        time.sleep(_LOOK_S)


def _step(stage: AgentStage, duration: float) -> None:
    until = time.monotonic() + duration
    while stage.step().t < until:
        pass


def _require_patrol(stage: AgentStage) -> None:
    """Raise EnduranceError if the robot has not moved lately; in a turn it stands for a moment."""
    since = stage.trace[-1].t - _LATELY_S
    if not any(moment.moving for moment in reversed(stage.trace) if moment.t > since):
        raise EnduranceError(f"the robot does not patrol: {stage.agent_log()[-200:]}")


def _require_readable(path: Path) -> None:
    if path.stat().st_size == 0:
        return  # killed before its header was written
    try:
        for _ in read_recording(path).items():
            pass
    except RecordingError as error:
        raise EnduranceError(str(error)) from error
