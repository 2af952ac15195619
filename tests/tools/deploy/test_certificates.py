"""With certificates, a robot can publish under its certificate's name only."""

from __future__ import annotations

import stat
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import msgspec
import pytest
import zenoh

from robot_agent.config import TelemetrySettings
from robot_agent.messages.streams import encode
from robot_agent.process.telemetry import Telemetry, session_config
from tests.tools.monitor.reports import pose
from tools.deploy.certificates import KEY, KeysError, known_robots, make_keys
from tools.monitor.endpoint import free_endpoint
from tools.monitor.operator import Operator, OperatorError

TIMEOUT_S = 20.0


@pytest.fixture(scope="module")
def keys(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("keys")
    make_keys(folder, "north", ["anna", "bob"], ["127.0.0.1"])
    return folder


@pytest.fixture
def endpoint() -> str:
    return free_endpoint().replace("tcp/", "tls/")


def wait_until(condition: Callable[[], bool], what: str) -> None:
    deadline = time.monotonic() + TIMEOUT_S
    while not condition():
        assert time.monotonic() < deadline, what
        time.sleep(0.02)


def test_robots_report_with_their_certificates(keys: Path, endpoint: str) -> None:
    with closing(Operator(endpoint, keys=keys / "operator")) as operator:
        settings = TelemetrySettings(operator=endpoint, keys=str(keys / "anna"))
        robot = Telemetry(settings, robot="anna", team="north")
        wait_until(lambda: [r.online for r in operator.team.snapshot()] == [True], "anna online")
        robot.publish("pose", encode(pose(1.0)))
        wait_until(lambda: operator.team.snapshot()[0].pose == pose(1.0), "anna's pose")
        robot.close()
        assert robot.failed == ""


def test_payloads_under_another_robots_name_are_denied(keys: Path, endpoint: str) -> None:
    with (
        closing(Operator(endpoint, keys=keys / "operator")) as operator,
        zenoh.open(session_config(endpoint, str(keys / "anna"))) as forger,
    ):
        wait_until(lambda: bool(list(forger.info.routers_zid())), "the forger's connection")
        for key in ("patrol/north/bob/pose", "patrol/south/anna/pose", "patrol/north/annabel/pose"):
            forger.put(key, encode(pose(1.0)))
        token = forger.liveliness().declare_token("patrol/north/bob")
        forger.put("patrol/north/anna/pose", encode(pose(2.0)))
        wait_until(lambda: bool(operator.team.snapshot()), "anna's own pose, sent last")
        (robot,) = operator.team.snapshot()
        assert (robot.id, robot.pose, operator.team.stray) == ("north/anna", pose(2.0), 0)
        token.undeclare()  # type: ignore[no-untyped-call]


def test_clients_without_a_certificate_of_the_authority_are_denied(
    keys: Path, endpoint: str, tmp_path: Path
) -> None:
    make_keys(tmp_path, "north", ["anna"], ["127.0.0.1"])
    with closing(Operator(endpoint, keys=keys / "operator")) as operator:
        foreign = TelemetrySettings(operator=endpoint, keys=str(tmp_path / "anna"))
        plain = TelemetrySettings(operator=endpoint.replace("tls/", "tcp/"))
        strangers = [Telemetry(each, robot="anna", team="north") for each in (foreign, plain)]
        known = TelemetrySettings(operator=endpoint, keys=str(keys / "bob"))
        friend = Telemetry(known, robot="bob", team="north")
        for _ in range(20):
            for stranger in (*strangers, friend):
                stranger.publish("pose", encode(pose(1.0)))
            time.sleep(0.05)
        wait_until(lambda: bool(operator.team.snapshot()), "the one with a certificate")
        assert [robot.id for robot in operator.team.snapshot()] == ["north/bob"]
        for each in (*strangers, friend):
            each.close()


def test_keys_are_private_and_existing_ones_are_kept(tmp_path: Path) -> None:
    assert make_keys(tmp_path, "north", ["anna"], ["laptop.local"]) == [
        "authority",
        "operator",
        "anna",
    ]
    before = (tmp_path / "anna" / KEY).read_bytes()
    assert make_keys(tmp_path, "north", ["anna", "bob"], []) == ["bob"]
    assert (tmp_path / "anna" / KEY).read_bytes() == before
    assert [name.robot for name in known_robots(tmp_path / "operator")] == ["anna", "bob"]
    for path in tmp_path.rglob(KEY):
        assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_invalid_keys_and_endpoints_are_one_error(tmp_path: Path, endpoint: str) -> None:
    with pytest.raises(KeysError, match="give --host"):
        make_keys(tmp_path, "north", ["anna"], [])
    for robot in ("operator", "an/na", ""):
        with pytest.raises(KeysError, match="robot"):
            make_keys(tmp_path, "north", [robot], ["127.0.0.1"])
    with pytest.raises(KeysError, match=r"robots\.json"):
        known_robots(tmp_path / "absent")
    with pytest.raises(OperatorError, match="--keys"):
        Operator(endpoint)
    with pytest.raises(msgspec.ValidationError, match="needs keys"):
        msgspec.convert({"operator": "tls/host:7447"}, TelemetrySettings)
