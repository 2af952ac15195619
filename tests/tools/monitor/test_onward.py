"""Telemetry forwarded by the monitor: to a head office, and to Foxglove viewers."""

from __future__ import annotations

import asyncio
import struct
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, closing
from pathlib import Path

import aiohttp
import pytest
import zenoh

from maps.zone import Zone
from robot_agent.config import TelemetrySettings
from robot_agent.messages.streams import encode
from robot_agent.process.telemetry import Telemetry, session_config
from tests.tools.monitor.reports import pose
from tools.cli import main
from tools.deploy.certificates import make_keys
from tools.monitor import forwarder
from tools.monitor.endpoint import free_endpoint
from tools.monitor.foxglove_server import FoxgloveServer
from tools.monitor.monitor import Monitor, MonitorOptions
from tools.monitor.operator import Operator
from tools.monitor.page_server import WebError
from tools.monitor.site import Site

TIMEOUT_S = 20.0


def wait_until(condition: Callable[[], bool], what: str) -> None:
    deadline = time.monotonic() + TIMEOUT_S
    while not condition():
        assert time.monotonic() < deadline, what
        time.sleep(0.02)


def test_head_office_receives_the_robots_of_two_sites() -> None:
    office_endpoint = free_endpoint()
    sites = [free_endpoint(), free_endpoint()]
    options = [MonitorOptions(site, None, Site(None), forward=office_endpoint) for site in sites]
    with (
        closing(Monitor(MonitorOptions(office_endpoint, None, Site(None)))) as office,
        closing(Monitor(options[0])) as first,
        closing(Monitor(options[1])),
    ):
        robots = [
            Telemetry(TelemetrySettings(operator=site), robot=f"robot{number}", team="north")
            for number, site in enumerate(sites)
        ]

        def report() -> list[str]:
            for number, robot in enumerate(robots):
                robot.publish("pose", encode(pose(1.0, float(number))))
            return [robot.id for robot in office.operator.team.snapshot() if robot.poses]

        wait_until(lambda: report() == ["north/robot0", "north/robot1"], "both sites' robots")
        heard = office.operator.team.snapshot()
        assert [robot.poses[-1][1].x for robot in heard] == [0.0, 1.0]
        assert all(robot.online for robot in heard)
        assert [robot.id for robot in first.operator.team.snapshot()] == ["north/robot0"]
        for robot in robots:
            robot.close()


@pytest.fixture
def office_keys(tmp_path: Path) -> Path:
    """Keys that a head office made: its own, and those of the site of team north."""
    make_keys(tmp_path, "north", [], ["127.0.0.1"], site=True)
    return tmp_path


def test_head_office_with_certificates_receives_a_whole_team_from_its_site(
    office_keys: Path,
) -> None:
    office_endpoint, site_endpoint = free_endpoint().replace("tcp/", "tls/"), free_endpoint()
    site = MonitorOptions(
        *(site_endpoint, None, Site(None)),
        forward=office_endpoint,
        forward_keys=office_keys / "north.site",
    )
    office = MonitorOptions(office_endpoint, None, Site(None), keys=office_keys / "operator")
    with closing(Monitor(office)) as head, closing(Monitor(site)) as monitor:
        settings = TelemetrySettings(operator=site_endpoint)
        robots = [
            Telemetry(settings, robot=name, team=team)
            for team, name in (("south", "carl"), ("north", "anna"), ("north", "bob"))
        ]

        def report() -> list[str]:
            for robot in robots:
                robot.publish("pose", encode(pose(1.0)))
            return [robot.id for robot in head.operator.team.snapshot() if robot.poses]

        wait_until(lambda: len(report()) == 2, "the team's robots")
        assert report() == ["north/anna", "north/bob"], "none of a team that is not the site's"
        assert all(robot.online for robot in head.operator.team.snapshot())
        assert len(monitor.operator.team.snapshot()) == 3
        assert list(monitor.conditions()) == []
        for robot in robots:
            robot.close()


def test_robot_cannot_report_as_a_site(office_keys: Path) -> None:
    make_keys(office_keys, "north", ["anna"], [])
    endpoint = free_endpoint().replace("tcp/", "tls/")
    with (
        closing(Operator(endpoint, keys=office_keys / "operator")) as office,
        zenoh.open(session_config(endpoint, str(office_keys / "anna"))) as robot,
    ):
        wait_until(lambda: bool(list(robot.info.routers_zid())), "the robot's connection")
        robot.put("patrol/north/bob/pose", encode(pose(1.0)))
        robot.put("patrol/north/anna/pose", encode(pose(2.0)))
        wait_until(lambda: bool(office.team.snapshot()), "its own pose, sent last")
        assert [each.id for each in office.team.snapshot()] == ["north/anna"]


@pytest.mark.parametrize("office", ["tls/127.0.0.1:7447", "office", "udp/127.0.0.1:7447", ""])
def test_office_that_cannot_be_reached_so_is_one_line(
    office: str, capsys: pytest.CaptureFixture[str]
) -> None:
    listen = ["--listen", free_endpoint(), "--text", "--duration", "0.1"]
    assert main(["monitor", *listen, "--forward", office]) == (1 if office else 0)
    told = capsys.readouterr().err
    assert told.count("\n") == (1 if office else 0)
    assert not office or "--forward-keys" in told


def test_certificate_of_the_site_that_has_ended_is_told_by_its_monitor(office_keys: Path) -> None:
    make_keys(office_keys, "south", [], [], days=-1, site=True)
    office = free_endpoint().replace("tcp/", "tls/")
    site = MonitorOptions(
        *(free_endpoint(), None, Site(None)),
        forward=office,
        forward_keys=office_keys / "south.site",
    )
    with closing(Operator(office, keys=office_keys / "operator")), closing(Monitor(site)) as own:
        settings = TelemetrySettings(operator=site.listen)
        with closing(Telemetry(settings, robot="carl", team="south")) as robot:

            def told() -> dict[str, str]:
                robot.publish("pose", encode(pose(1.0)))
                return {each.kind: each.text for each in own.conditions()}

            wait_until(lambda: "office" in told(), "the trouble with the office")
            assert "was valid until" in told()["office"]
            assert told()["keys certificate.pem"].startswith("the office hears nothing: ")


@asynccontextmanager
async def foxglove_viewer(port: int) -> AsyncIterator[aiohttp.ClientWebSocketResponse]:
    """Connect as a viewer of Foxglove does."""
    address, protocols = f"http://127.0.0.1:{port}/", ["foxglove.sdk.v1"]
    async with (
        aiohttp.ClientSession() as session,
        session.ws_connect(address, protocols=protocols) as viewer,
    ):
        yield viewer


def test_foxglove_viewer_gets_channels_with_schemas_and_payloads() -> None:
    pytest.importorskip("foxglove", reason="foxglove-sdk is not installed")
    payload = encode(pose(1.0))

    async def look(port: int, server: FoxgloveServer) -> None:
        async with foxglove_viewer(port) as viewer:
            while True:
                server.on_payload("patrol/north/anna/pose", payload, time.time())
                try:
                    message = await viewer.receive(timeout=0.5)
                except TimeoutError:
                    continue  # published before the viewer had subscribed
                if message.type is aiohttp.WSMsgType.BINARY and message.data.endswith(payload):
                    return
                if message.type is aiohttp.WSMsgType.TEXT and '"advertise"' in message.data:
                    channel = message.json()["channels"][0]
                    assert channel["topic"] == "/patrol/north/anna/pose"
                    assert channel["schemaName"] == "foxglove.PoseInFrame"
                    wanted = {
                        "op": "subscribe",
                        "subscriptions": [{"id": 1, "channelId": channel["id"]}],
                    }
                    await viewer.send_json(wanted)

    with closing(FoxgloveServer("127.0.0.1:0")) as server:
        server.on_payload("patrol/north/anna/nonsense", b"{}", time.time())
        asyncio.run(look(server.port, server))
        with pytest.raises(WebError, match="--foxglove"):
            FoxgloveServer(f"127.0.0.1:{server.port}")


def test_foxglove_viewer_gets_the_zones_whenever_it_subscribes() -> None:
    pytest.importorskip("foxglove", reason="foxglove-sdk is not installed")
    zone = Zone("küchen corridor", ((2.5, 1.25), (8.0, 1.25), (8.0, 3.0)))

    async def zones_seen(port: int) -> bytes:
        async with foxglove_viewer(port) as viewer:
            while True:
                message = await viewer.receive(timeout=TIMEOUT_S)
                if message.type is aiohttp.WSMsgType.BINARY:
                    return bytes(message.data)
                if message.type is aiohttp.WSMsgType.TEXT and '"advertise"' in message.data:
                    (channel,) = message.json()["channels"]
                    assert (channel["topic"], channel["schemaName"]) == (
                        "/zones",
                        "foxglove.SceneUpdate",
                    )
                    wanted = {"id": 1, "channelId": channel["id"]}
                    await viewer.send_json({"op": "subscribe", "subscriptions": [wanted]})

    with closing(FoxgloveServer("127.0.0.1:0", [zone])) as server:
        for _ in range(2):  # a viewer that comes later gets them too
            scene = asyncio.run(zones_seen(server.port))
            assert zone.name.encode() in scene
            for number in (2.5, 1.25, 8.0, 3.0):
                assert struct.pack("<d", number) in scene


def test_silent_robot_gives_its_place_at_the_office_to_a_later_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(forwarder, "MAX_ROBOTS", 2)
    with closing(forwarder.Forwarder(free_endpoint())) as onward:
        for wall, name in ((0.0, "a"), (0.0, "b"), (1.0, "c"), (4.0, "a"), (6.0, "c")):
            onward.on_payload(f"patrol/north/{name}/pose", b"{}", wall)
        assert [name for _team, name in onward._robots] == ["a", "c"]
