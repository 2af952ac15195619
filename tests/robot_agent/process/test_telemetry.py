from __future__ import annotations

import json
import queue
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import msgspec
import psutil
import pytest
import zenoh

from maps.input_limits import MAX_QUEUE_BYTES
from robot_agent.config import TelemetrySettings
from robot_agent.process.telemetry import Telemetry, session_config
from tools.deploy.child_program import environment, program
from tools.monitor.operator import Operator

PATIENCE_S = 15.0


@pytest.fixture
def endpoint() -> str:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


class Listener:
    """An operator that queues what it receives."""

    def __init__(self, listen: str) -> None:
        self.heard: queue.Queue[tuple[str, bytes]] = queue.Queue()
        self.liveliness: queue.Queue[tuple[str, bool]] = queue.Queue()
        self._operator = Operator(listen)
        session = self._operator._session
        session.declare_subscriber(
            "patrol/**", lambda s: self.heard.put((str(s.key_expr), bytes(s.payload)))
        )
        session.liveliness().declare_subscriber(
            "patrol/**",
            lambda s: self.liveliness.put((str(s.key_expr), s.kind == zenoh.SampleKind.PUT)),
            history=True,
        )

    def close(self) -> None:
        self._operator.close()


Listen = Callable[[str], Listener]


@pytest.fixture
def listen() -> Iterator[Listen]:
    listeners = []

    def start(endpoint: str) -> Listener:
        listeners.append(Listener(endpoint))
        return listeners[-1]

    yield start
    for listener in listeners:
        listener.close()


Tell = Callable[..., Telemetry]


@pytest.fixture
def tell() -> Iterator[Tell]:
    opened = []

    def start(endpoint: str, **options: int) -> Telemetry:
        chosen = TelemetrySettings(operator=endpoint)
        opened.append(Telemetry(chosen, robot="anna", team="north", **options))
        return opened[-1]

    yield start
    for telemetry in opened:
        telemetry.close()


def test_operator_receives_payloads_and_liveliness(
    endpoint: str, listen: Listen, tell: Tell
) -> None:
    operator = listen(endpoint)
    telemetry = tell(endpoint)
    assert operator.liveliness.get(timeout=PATIENCE_S) == ("patrol/north/anna", True)
    telemetry.publish("status", b'{"a":1}')
    assert operator.heard.get(timeout=PATIENCE_S) == ("patrol/north/anna/status", b'{"a":1}')
    telemetry.publish("event", b"the last word")
    telemetry.close()
    assert operator.heard.get(timeout=PATIENCE_S) == ("patrol/north/anna/event", b"the last word")
    assert operator.liveliness.get(timeout=PATIENCE_S) == ("patrol/north/anna", False)
    assert (telemetry.failed, telemetry.dropped, telemetry.sent) == ("", 0, 2)


def test_operator_started_later_is_connected(endpoint: str, listen: Listen, tell: Tell) -> None:
    telemetry = tell(endpoint)
    telemetry.publish("status", b"nobody hears this")
    operator = listen(endpoint)
    assert operator.liveliness.get(timeout=PATIENCE_S) == ("patrol/north/anna", True)
    telemetry.publish("status", b"now")
    assert operator.heard.get(timeout=PATIENCE_S) == ("patrol/north/anna/status", b"now")


def test_restarted_operator_is_reconnected(endpoint: str, listen: Listen, tell: Tell) -> None:
    telemetry = tell(endpoint)
    for word in (b"first", b"second", b"third"):
        operator = listen(endpoint)
        assert operator.liveliness.get(timeout=PATIENCE_S) == ("patrol/north/anna", True)
        telemetry.publish("status", word)
        assert operator.heard.get(timeout=PATIENCE_S) == ("patrol/north/anna/status", word)
        operator.close()
    assert telemetry.failed == ""


def test_absent_operator_does_not_block(endpoint: str, tell: Tell) -> None:
    start = time.monotonic()
    telemetry = tell(endpoint)
    for _ in range(10_000):
        telemetry.publish("scan", bytes(3000))
    telemetry.close()
    assert time.monotonic() - start < 5.0
    assert telemetry.failed == ""


def test_hanging_operator_does_not_block(tell: Tell) -> None:
    """A host that accepts the connection and never sends a byte."""
    with socket.create_server(("127.0.0.1", 0)) as mute:
        start = time.monotonic()
        telemetry = tell(f"tcp/127.0.0.1:{mute.getsockname()[1]}")
        for _ in range(10_000):
            telemetry.publish("scan", bytes(3000))
        telemetry.close()
        assert time.monotonic() - start < 5.0


def test_frozen_operator_drops_and_counts_the_oldest_payloads(endpoint: str, tell: Tell) -> None:
    """An operator that stops in mid-message: the network fills up, then the queue."""
    command = program("tools.cli", "monitor", "--text", "--listen", endpoint)
    with subprocess.Popen(command, env=environment(), stdout=subprocess.DEVNULL) as operator:
        try:
            telemetry = tell(endpoint)
            deadline = time.monotonic() + 2 * PATIENCE_S
            while not telemetry.connected:
                assert time.monotonic() < deadline, "the operator did not come"
                time.sleep(0.02)
            operator.send_signal(signal.SIGSTOP)
            published, slowest = 0, 0.0
            while not telemetry.dropped:
                assert time.monotonic() < deadline, "nothing was dropped"
                before = time.thread_time()
                telemetry.publish("scan", bytes(20_000))
                slowest = max(slowest, time.thread_time() - before)
                published += 1
                time.sleep(0.0005)
            assert slowest < 0.05
            assert telemetry.sent + telemetry.dropped <= published
        finally:
            operator.kill()


def test_full_queue_drops_the_oldest_and_counts(endpoint: str, listen: Listen, tell: Tell) -> None:
    operator = listen(endpoint)
    telemetry = tell(endpoint, queue=2)
    assert operator.liveliness.get(timeout=PATIENCE_S) == ("patrol/north/anna", True)
    count = 20_000
    for number in range(count):
        telemetry.publish("status", b"%d" % number)
    telemetry.close()
    assert telemetry.dropped > 0
    assert telemetry.dropped + telemetry.sent == count
    last = -1
    while last < count - 1:
        number = int(operator.heard.get(timeout=PATIENCE_S)[1])
        assert number > last
        last = number


def test_queue_is_bounded_in_bytes() -> None:
    telemetry = Telemetry(
        TelemetrySettings(operator="tcp/127.0.0.1:1"), robot="anna", team="north", queue=1000
    )
    for _ in range(20):
        telemetry.publish("scan", bytes(MAX_QUEUE_BYTES // 4))
    telemetry.close()
    assert telemetry.dropped + telemetry.sent >= 20 - 4


def test_without_an_operator_nothing_is_opened() -> None:
    telemetry = Telemetry(TelemetrySettings(), robot="anna", team="north")
    telemetry.publish("status", b"{}")
    telemetry.close()
    assert (telemetry.failed, telemetry.sent, telemetry.dropped) == ("", 0, 0)


REPOSITORY = Path(__file__).resolve().parents[3]
NO_OPERATOR = """
import sys
from robot_agent.process.telemetry import Telemetry
from robot_agent.config import TelemetrySettings
telemetry = Telemetry(TelemetrySettings(), robot="anna", team="north")
telemetry.publish("status", b"{}")
telemetry.close()
print("zenoh" in sys.modules)
"""


def test_without_an_operator_zenoh_is_not_even_imported() -> None:
    output = subprocess.run(
        [sys.executable, "-c", NO_OPERATOR],
        cwd=REPOSITORY,
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert output == "False\n"


ROBOT = """
import sys
from robot_agent.process.telemetry import Telemetry
from robot_agent.config import TelemetrySettings
telemetry = Telemetry(TelemetrySettings(operator=sys.argv[1]), robot="anna", team="north")
sys.stdin.read()
telemetry.close()
"""


def test_robot_listens_on_nothing_and_has_one_connection(endpoint: str, listen: Listen) -> None:
    operator = listen(endpoint)
    with subprocess.Popen(
        [sys.executable, "-c", ROBOT, endpoint], cwd=REPOSITORY, stdin=subprocess.PIPE
    ) as process:
        assert operator.liveliness.get(timeout=PATIENCE_S) == ("patrol/north/anna", True)
        (connection,) = psutil.Process(process.pid).net_connections(kind="inet")
        assert connection.status == psutil.CONN_ESTABLISHED
        assert connection.raddr.port == int(endpoint.rpartition(":")[2])
        process.kill()
    assert operator.liveliness.get(timeout=PATIENCE_S) == ("patrol/north/anna", False)


@pytest.fixture
def open_router(endpoint: str) -> Iterator[zenoh.Session]:
    config = zenoh.Config()
    config.insert_json5("mode", '"router"')
    config.insert_json5("listen/endpoints", json.dumps([endpoint]))
    config.insert_json5("scouting/multicast/enabled", "false")
    with zenoh.open(config) as session:
        yield session


class Spy:
    """Another client on the network that subscribes to the robots' payloads."""

    def __init__(self, endpoint: str, mode: str) -> None:
        config = session_config(endpoint)
        config.insert_json5("mode", json.dumps(mode))
        config.insert_json5("scouting/delay", "500")
        config.insert_json5("open/return_conditions", '{"connect_scouted": true}')
        self.heard: queue.Queue[str] = queue.Queue()
        self.session = zenoh.open(config)
        self.session.declare_subscriber("**", lambda s: self.heard.put(str(s.key_expr)))
        self.session.liveliness().declare_subscriber(
            "**", lambda s: self.heard.put(str(s.key_expr)), history=True
        )

    def wait_until_connected(self) -> None:
        deadline = time.monotonic() + PATIENCE_S
        while not self.session.info.routers_zid():
            assert time.monotonic() < deadline, "the spy did not get through"
            time.sleep(0.02)


@pytest.mark.parametrize("mode", ["peer", "client", "router"])
def test_other_clients_receive_nothing_through_the_operator(
    endpoint: str, listen: Listen, tell: Tell, mode: str
) -> None:
    operator = listen(endpoint)
    spy = Spy(endpoint, mode)
    spy.wait_until_connected()
    telemetry = tell(endpoint)
    assert operator.liveliness.get(timeout=PATIENCE_S) == ("patrol/north/anna", True)
    for number in range(50):
        telemetry.publish("status", b"%d" % number)
        assert operator.heard.get(timeout=PATIENCE_S)[1] == b"%d" % number
    assert list(spy.session.get("patrol/**", timeout=0.3)) == []
    assert list(spy.session.liveliness().get("patrol/**", timeout=0.3)) == []
    spy.wait_until_connected()
    spy.session.close()  # type: ignore[no-untyped-call]
    assert spy.heard.empty()


@pytest.mark.parametrize("mode", ["client", "router"])
def test_same_client_receives_through_an_open_router(
    endpoint: str, open_router: zenoh.Session, tell: Tell, mode: str
) -> None:
    spy = Spy(endpoint, mode)
    telemetry = tell(endpoint)
    deadline = time.monotonic() + PATIENCE_S
    heard: set[str] = set()
    while len(heard) < 2 and time.monotonic() < deadline:
        telemetry.publish("status", b"{}")
        heard.add(spy.heard.get(timeout=PATIENCE_S))
    spy.session.close()  # type: ignore[no-untyped-call]
    assert heard == {"patrol/north/anna", "patrol/north/anna/status"}


@pytest.mark.parametrize("operator", ["localhost", "tcp/", "tcp/host", "udp/host:1", "tcp/a b:1"])
def test_endpoint_is_checked_with_the_configuration(operator: str) -> None:
    with pytest.raises(msgspec.ValidationError, match="operator"):
        msgspec.convert({"operator": operator}, TelemetrySettings)
