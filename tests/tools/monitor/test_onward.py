"""Telemetry forwarded by the monitor: to a head office, and to Foxglove viewers."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from contextlib import closing

import aiohttp
import pytest

from robot_agent.config import TelemetrySettings
from robot_agent.messages.streams import encode
from robot_agent.process.telemetry import Telemetry
from tests.tools.monitor.reports import pose
from tools.monitor import forwarder
from tools.monitor.endpoint import free_endpoint
from tools.monitor.foxglove_server import FoxgloveServer
from tools.monitor.monitor import Monitor, MonitorOptions
from tools.monitor.site import Site
from tools.monitor.web_server import WebError

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


def test_foxglove_viewer_gets_channels_with_schemas_and_payloads() -> None:
    pytest.importorskip("foxglove", reason="foxglove-sdk is not installed")
    payload = encode(pose(1.0))

    async def look(port: int, server: FoxgloveServer) -> None:
        async with (
            aiohttp.ClientSession() as session,
            session.ws_connect(
                f"http://127.0.0.1:{port}/", protocols=["foxglove.sdk.v1"]
            ) as viewer,
        ):
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


def test_silent_robot_gives_its_place_at_the_office_to_a_later_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(forwarder, "MAX_ROBOTS", 2)
    with closing(forwarder.Forwarder(free_endpoint())) as onward:
        for wall, name in ((0.0, "a"), (0.0, "b"), (1.0, "c"), (4.0, "a"), (6.0, "c")):
            onward.on_payload(f"patrol/north/{name}/pose", b"{}", wall)
        assert [name for _team, name in onward._robots] == ["a", "c"]
