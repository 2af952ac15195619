"""Control loop times of one robot under every network fault: telemetry must not delay them."""

from __future__ import annotations

import signal
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from robot_agent.config import TelemetrySettings
from robot_agent.messages.streams import ProcessPayload
from robot_agent.process.telemetry import Telemetry
from tools.campaign.agent_stage import AgentStage
from tools.deploy.child_program import environment, program
from tools.logs.recording import read_recording
from tools.monitor.endpoint import free_endpoint
from tools.monitor.operator import Operator

SEED = 1
SETTLED_S = 7.0
"""Time after which an agent has connected, localized and started to patrol."""


@dataclass(frozen=True)
class LoopTiming:
    """Response times of one robot's control loop, s: last report byte to first command byte."""

    trouble: str
    median: float
    p99: float
    longest: float
    memory_mb: float
    dropped: int
    """Payloads dropped from the full queue in favour of newer ones."""


@contextmanager
def _process(module: str, *words: str) -> Iterator[subprocess.Popen[bytes]]:
    command = program(module, *words)
    with subprocess.Popen(command, env=environment(), stdout=subprocess.DEVNULL) as process:
        try:
            yield process
        finally:
            process.send_signal(signal.SIGCONT)
            process.kill()


def _port(endpoint: str) -> str:
    return endpoint.rpartition(":")[2]


class Network:
    """The network end of the robot's telemetry: operator processes, started by the fault."""

    def __init__(self, stack: ExitStack) -> None:
        self._stack = stack
        self.endpoint = free_endpoint()
        """Endpoint the robot connects to."""

    def start_operator(self, endpoint: str | None = None) -> subprocess.Popen[bytes]:
        """Start an operator listening on an endpoint; None: the one the robot connects to."""
        words = ("tools.cli", "monitor", "--text", "--listen", endpoint or self.endpoint)
        return self._stack.enter_context(_process(*words))

    def start_bad_link(self) -> None:
        """Start an operator and a bad link between the robot and it."""
        behind = free_endpoint()
        self.start_operator(behind)
        words = ("tools.benchmark.bad_link", _port(self.endpoint), _port(behind))
        self._stack.enter_context(_process(*words))


Disturbance = Callable[[Network, float], None]
"""Called at every step of a measurement with the time since its start, s."""


def _no_disturbance(_network: Network, _t: float) -> None:
    """Leave the network as it is."""


class _Freezer:
    """Stops the operator process by SIGSTOP, in mid-message, and does not continue it."""

    def __init__(self, operator: subprocess.Popen[bytes]) -> None:
        self._operator = operator
        self._frozen = False

    def __call__(self, _network: Network, t: float) -> None:
        if not self._frozen and t > SETTLED_S - 1.0:
            self._frozen = True
            self._operator.send_signal(signal.SIGSTOP)


class _Restarter:
    """Kills the operator and starts another one, alternately every ``PERIOD_S``."""

    PERIOD_S = 3.0

    def __init__(self, operator: subprocess.Popen[bytes]) -> None:
        self._operator: subprocess.Popen[bytes] | None = operator
        self._next = SETTLED_S

    def __call__(self, network: Network, t: float) -> None:
        if t < self._next:
            return
        self._next += self.PERIOD_S
        if self._operator is not None:
            self._operator.kill()
            self._operator = None
        else:
            self._operator = network.start_operator()


def _with_bad_link(network: Network) -> Disturbance:
    network.start_bad_link()
    return _no_disturbance


TROUBLES: dict[str, Callable[[Network], Disturbance] | None] = {
    "no telemetry": None,
    "operator absent": lambda _network: _no_disturbance,
    "operator hears": lambda network: _undisturbed(network.start_operator()),
    "operator frozen in mid-message": lambda network: _Freezer(network.start_operator()),
    "operator killed and restarted": lambda network: _Restarter(network.start_operator()),
    "bad link: 0.5 s late, 1 % stalls": _with_bad_link,
}


def _undisturbed(_operator: subprocess.Popen[bytes]) -> Disturbance:
    return _no_disturbance


def loop_timings(measured: float, rounds: int = 3) -> Iterator[LoopTiming]:
    """Measure every fault for ``measured`` s of real time, in several rounds.

    Of each time the smallest is kept, as other load on the machine can only add; of memory and
    dropped payloads the largest.
    """
    timings: dict[str, list[LoopTiming]] = {trouble: [] for trouble in TROUBLES}
    for _ in range(rounds):
        for trouble, found in timings.items():
            with tempfile.TemporaryDirectory() as folder:
                found.append(_timing(trouble, Path(folder), measured))
    for trouble, found in timings.items():
        yield LoopTiming(
            trouble,
            min(timing.median for timing in found),
            min(timing.p99 for timing in found),
            min(timing.longest for timing in found),
            max(timing.memory_mb for timing in found),
            max(timing.dropped for timing in found),
        )


def _timing(trouble: str, folder: Path, measured: float) -> LoopTiming:
    with ExitStack() as stack:
        network = Network(stack)
        prepare = TROUBLES[trouble]
        disturb = _no_disturbance if prepare is None else prepare(network)
        operator = "" if prepare is None else network.endpoint
        stage = stack.enter_context(closing(AgentStage(folder, SEED, operator)))
        stage.start_agent()
        started = time.monotonic()
        while (t := time.monotonic() - started) < SETTLED_S + measured:
            disturb(network, t)
            stage.step()
            if t < SETTLED_S:
                stage.tap.response_times.clear()
        stage.end_agent()
        times = np.array(stage.tap.response_times)
        process = _last_process_report(stage.recordings[-1])
    return LoopTiming(
        trouble,
        float(np.median(times)),
        float(np.percentile(times, 99)),
        float(times.max()),
        process.memory_mb,
        process.telemetry_dropped,
    )


def _last_process_report(recording: Path) -> ProcessPayload:
    """Return the last process report of a recording."""
    *_, (_, _, payload) = read_recording(recording).messages({"process"})
    return msgspec.json.decode(payload, type=ProcessPayload)


def reconnection_time(absence: float) -> float:
    """Return the time, s, from an operator's start to a robot's reconnection.

    absence: time, s, that the robot runs without an operator before.
    """
    endpoint = free_endpoint()
    robot = Telemetry(TelemetrySettings(operator=endpoint), robot="robot1", team="faults")
    try:
        time.sleep(absence)
        with closing(Operator(endpoint)) as operator:
            back = time.monotonic()
            while not any(state.online for state in operator.team.snapshot()):
                time.sleep(0.01)
            return time.monotonic() - back
    finally:
        robot.close()
