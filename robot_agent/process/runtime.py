"""The runtime of a live agent: links, real time, threads.

Reader threads put time-stamped events into one inbox; one consumer passes them to the agent and
carries out its effects. Recorder and telemetry get copies and never block the consumer.
"""

from __future__ import annotations

import math
import signal
import time
from contextlib import ExitStack
from queue import Empty, SimpleQueue
from types import FrameType

from drivers.camera import Camera
from drivers.camera_source import CameraTrouble
from drivers.link import Link
from drivers.port_error import PortTrouble
from robot_agent.agent import Agent
from robot_agent.messages.effects import ChangeBaud, Effect, Publish, Remember, Send, TakePicture
from robot_agent.messages.events import (
    TICK_S,
    BytesReceived,
    Event,
    LinkDown,
    LinkName,
    LinkUp,
    OperatorKey,
    Shutdown,
    Tick,
)
from robot_agent.messages.foxglove import Log, timestamp_at
from robot_agent.messages.log_level import LogLevel
from robot_agent.messages.streams import encode
from robot_agent.perception.picture_reader import PictureReader
from robot_agent.process.brief_holds import BriefHolds
from robot_agent.process.journal import Journal
from robot_agent.process.pose_file import PoseFile
from robot_agent.process.process_watch import ProcessWatch
from robot_agent.process.service_notifier import ServiceNotifier
from robot_agent.process.side_writer import SideWriter
from robot_agent.process.telemetry import Telemetry
from robot_agent.process.wall_clock import clock_trouble
from robot_agent.recording.recorder import Recorder
from robot_agent.recording.recording_writer import Note

FILTERED_S = 10.0
"""s for which a device that is there may be kept out by the service's filter."""
JOURNAL_LINES = 1000
"""Lines that may wait for standard error, which a stalled journal blocks."""
SHUTDOWN_S = 0.3
"""s for the last commands to be sent and take effect before the ports close."""


class Clock:
    """Seconds since the agent's start, monotonic, in whole microseconds."""

    def __init__(self) -> None:
        self.start_wall_ns = time.time_ns()
        self.start_monotonic_ns = time.monotonic_ns()

    def __call__(self) -> float:
        """Return the time now."""
        return (time.monotonic_ns() - self.start_monotonic_ns) // 1000 / 1e6


class LinkInbox:
    """Puts the reports of one link into the inbox as events (called on the link's thread)."""

    def __init__(self, link: LinkName, inbox: SimpleQueue[Event]) -> None:
        self._link = link
        self._inbox = inbox

    def received(self, t: float, data: bytes) -> None:
        """Put bytes that arrived at t."""
        self._inbox.put(BytesReceived(t, self._link, data))

    def link_up(self, t: float) -> None:
        """Put the event that the port was opened at t."""
        self._inbox.put(LinkUp(t, self._link))

    def link_down(self, t: float, reason: str) -> None:
        """Put the event that the port was lost or cannot be opened at t, with the reason."""
        self._inbox.put(LinkDown(t, self._link, reason))


class WorkerDiedError(RuntimeError):
    """A thread that the robot needs has ended; the agent must be restarted."""


class DeviceFilterError(RuntimeError):
    """The service's device filter keeps out a device that is there; a new start makes it anew."""


class Runtime:
    """Runs one agent until ``end`` is called."""

    def __init__(
        self,
        agent: Agent,
        clock: Clock,
        recorder: Recorder | None,
        telemetry: Telemetry,
        journal: Journal,
        pose_file: PoseFile | None = None,
    ) -> None:
        """Connect the parts; opens nothing, ``run`` does. Without a pose_file no pose is stored."""
        self._agent = agent
        self._clock = clock
        self._recorder = recorder
        self._telemetry = telemetry
        self._journal = SideWriter("journal", journal.write, JOURNAL_LINES)
        self._brief_holds = BriefHolds()
        self._pose_file = pose_file
        self._pose_writer: SideWriter | None = None
        if pose_file is not None:  # of the poses that wait only the newest counts
            self._pose_writer = SideWriter("pose file", pose_file.keep, 1)
        self._notifier = ServiceNotifier()
        self._watch = ProcessWatch(agent.config.robot.name, clock.start_wall_ns)
        self._troubles: dict[str, str] = {}
        self._filtered_since = math.inf
        self._inbox: SimpleQueue[Event] = SimpleQueue()
        self._links: dict[LinkName, Link] = {
            "base": self._make_link("base", agent.config.base.url, agent.config.base.baud),
            "laser": self._make_link("laser", agent.config.laser.url, agent.config.laser.baud),
        }

        self._picture_reader: PictureReader | None = None
        self._camera: Camera | None = None
        self._camera_died = False
        if agent.config.camera.url:
            color = agent.config.perception.color
            self._picture_reader = PictureReader(agent.config.camera, color, self._inbox.put)
            self._camera = Camera(agent.config.camera, clock, self._picture_reader)

    def _make_link(self, name: LinkName, url: str, baud: int) -> Link:
        return Link(url, baud, LinkInbox(name, self._inbox), self._clock)

    def end(self) -> None:
        """Request the agent to stop the robot and end; safe from any thread and signal handler."""
        self._inbox.put(Shutdown(self._clock()))

    def press(self, ahead: int, left: int) -> None:
        """Put a key of this terminal (``OperatorKey``) into the inbox; thread-safe."""
        self._inbox.put(OperatorKey(self._clock(), ahead, left))

    def run(self) -> None:
        """Process events until a Shutdown has been handled; stops the robot on any error too.

        Raises WorkerDiedError when a link's thread has died, DeviceFilterError when the service's
        filter has kept a device out for FILTERED_S.
        """
        with ExitStack() as stack:
            stack.callback(self._close_writers)
            stack.callback(self._close_links)
            if self._camera is not None:
                stack.callback(self._camera.close)
                self._camera.start()
            for link in self._links.values():
                link.start()
            self._notifier.running()
            try:
                self._serve()
            except BaseException:
                self._stop_robot()
                raise

    def _serve(self) -> None:
        """Handle events as they arrive, and ticks in between."""
        next_tick = self._clock()
        while True:
            event = self._next_event(next_tick)
            if isinstance(event, Tick):
                next_tick = event.t + TICK_S
                self._check_workers()
                self._check_filter(event.t)
            self._handle(event)
            self._notifier.alive(event.t)  # by this thread, which the watchdog supervises
            if isinstance(event, Shutdown):
                self._notifier.stopping()
                self._finish()
                return

    def _check_workers(self) -> None:
        """Raise WorkerDiedError if a link's thread has ended: no more data would arrive.

        Without the camera's thread the robot continues; its loss is reported once.
        """
        for name, link in self._links.items():
            if not link.alive:
                raise WorkerDiedError(f"the thread of the {name}'s link has died")
        if self._camera is not None and not self._camera.alive and not self._camera_died:
            self._camera_died = True
            reason = "the camera's thread has died: start the agent again"
            self._inbox.put(LinkDown(self._clock(), "camera", reason))

    def _check_filter(self, t: float) -> None:
        """Raise DeviceFilterError if a device that is there has been kept out for too long."""
        links = [link.status for link in self._links.values()]
        reasons = [each.reason for each in links if each.trouble is PortTrouble.FILTERED]
        if self._camera is not None and self._camera.status.trouble is CameraTrouble.FILTERED:
            reasons.append(self._camera.status.reason)
        if not reasons:
            self._filtered_since = math.inf
            return
        self._filtered_since = min(self._filtered_since, t)
        if t - self._filtered_since >= FILTERED_S:
            raise DeviceFilterError(reasons[0])

    def _next_event(self, next_tick: float) -> Event:
        """Return the next event of the inbox, or a tick when one is due."""
        wait = next_tick - self._clock()
        if wait > 0:
            try:
                return self._inbox.get(timeout=wait)
            except Empty:
                pass
        return Tick(self._clock())

    def _handle(self, event: Event) -> None:
        if self._recorder is not None:
            self._recorder.record_event(event)
        for effect in self._agent.handle(event):
            self._carry_out(effect)
            if self._recorder is not None:
                self._recorder.record_effect(event.t, effect)
        now = self._clock()
        if self._watch.handled(event.t, now):
            self._publish_process(now)

    def _publish_process(self, t: float) -> None:
        """Publish and record the process report, and failures of what runs beside the loop."""
        self._write_lines(self._brief_holds.due(t))
        lost, trouble = 0, ""
        if self._recorder is not None:
            lost, trouble = self._recorder.lost, self._recorder.trouble
        report = encode(
            self._watch.report(lost, trouble, self._telemetry.dropped, self._telemetry.connected)
        )
        self._note("process", "process", report, t)
        if not trouble and lost:
            trouble = "the disk was full or too slow: parts of the recording are lost"
        self._publish_trouble("recorder", trouble, t)
        self._publish_trouble("pose file", self._pose_trouble(), t)
        journal = (
            "takes no lines: they wait, and the oldest are lost" if self._journal.hangs else ""
        )
        self._publish_trouble("journal", journal, t)
        self._publish_trouble("telemetry", self._telemetry.failed, t)
        self._publish_trouble("clock", clock_trouble(time.time()), t)

    def _pose_trouble(self) -> str:
        if self._pose_file is None or self._pose_writer is None:
            return ""
        return (
            "the disk hangs: no pose is kept" if self._pose_writer.hangs else self._pose_file.failed
        )

    def _write_lines(self, payloads: list[bytes]) -> None:
        for payload in payloads:
            self._journal.put(payload)

    def _publish_trouble(self, part: str, trouble: str, t: float) -> None:
        """Publish, record and log a failure of a part outside the agent, once per text."""
        if trouble and trouble != self._troubles.get(part):
            stamp = timestamp_at(t, self._clock.start_wall_ns)
            log = Log(timestamp=stamp, level=LogLevel.ERROR, message=trouble, name=part)
            self._note("process_log", "event", encode(log), t)
            self._journal.put(encode(log))
        self._troubles[part] = trouble

    def _note(self, topic: str, stream: str, payload: bytes, t: float) -> None:
        self._telemetry.publish(stream, payload)
        if self._recorder is not None:
            self._recorder.record_note(Note(t, topic, payload))

    def _carry_out(self, effect: Effect) -> None:
        match effect:
            case Send(link, data):
                self._links[link].write(data)
            case ChangeBaud(link, baud):
                self._links[link].set_baud(baud)
            case TakePicture():
                if self._picture_reader is not None:
                    self._picture_reader.request_picture()
            case Remember(payload):
                if self._pose_writer is not None:
                    self._pose_writer.put(payload)
            case Publish(stream, payload):
                self._telemetry.publish(stream, payload)
                if stream == "event":
                    self._write_lines(self._brief_holds.lines(payload, self._clock()))

    def _finish(self) -> None:
        """Process events for SHUTDOWN_S more, so that the last commands are sent in order.

        A device that closes its connection after them has not failed.
        """
        for link in self._links.values():
            link.end()
        until = self._clock() + SHUTDOWN_S
        while (now := self._clock()) < until:
            self._handle(self._next_event(now + TICK_S))

    def _stop_robot(self) -> None:
        """Stop the robot after an exception in this process, if the sessions still work."""
        for effect in self._agent.handle(Shutdown(self._clock())):
            if isinstance(effect, Send):
                self._links[effect.link].write(effect.data)

    def _close_writers(self) -> None:
        self._journal.close()
        if self._pose_writer is not None and not self._pose_writer.close():
            assert self._pose_file is not None
            self._pose_file.failed = "the disk hangs: the last pose was not kept"

    def _close_links(self) -> None:
        for link in self._links.values():
            link.close()


def end_on_signals(runtime: Runtime) -> None:
    """Install handlers by which SIGINT and SIGTERM call ``runtime.end``."""

    def handler(_number: int, _frame: FrameType | None) -> None:
        runtime.end()

    signal.signal(signal.SIGINT, handler)
    signal.signal(signal.SIGTERM, handler)
