from __future__ import annotations

import asyncio
import json
import re
import socket
import time
from collections.abc import Awaitable, Callable, Iterator
from contextlib import closing
from typing import Any

import aiohttp
import pytest

from robot_agent.messages.streams import encode
from tests.tools.monitor.agent_recordings import START
from tests.tools.monitor.reports import decision, pose, status
from tests.tools.monitor.trouble_team import intruder
from tools.monitor.alarm import Condition, Severity
from tools.monitor.page_server import WebError
from tools.monitor.shift_log import ShiftLog
from tools.monitor.site import Site
from tools.monitor.source import LiveSource
from tools.monitor.team_state import TeamState
from tools.monitor.watch import Watch
from tools.monitor.web_server import PAGE_FOLDER, WebServer

KEY = "patrol/north/anna"
TROUBLE = Condition("north/anna", "battery", Severity.WARNING, "battery at 11.2 V")


@pytest.fixture
def server() -> Iterator[WebServer]:
    watch = Watch(TeamState(), Site(None), lambda: [TROUBLE])
    with closing(WebServer(watch, LiveSource(), "127.0.0.1:0")) as started:
        yield started


def get(url: str, encoding: str | None = None, **headers: str) -> tuple[int, dict[str, str], str]:
    async def fetch() -> tuple[int, dict[str, str], str]:
        async with aiohttp.ClientSession() as session, session.get(url, headers=headers) as answer:
            return answer.status, dict(answer.headers), await answer.text(encoding)

    return asyncio.run(fetch())


def test_page_has_a_strict_policy_and_loads_nothing_from_elsewhere(server: WebServer) -> None:
    status, headers, text = get(server.url)
    assert status == 200
    policy = headers["Content-Security-Policy"]
    assert policy.startswith("default-src 'none'; script-src 'self';")
    assert "unsafe" not in policy
    assert "<script>" not in text
    assert "style=" not in text
    for path in PAGE_FOLDER.iterdir():
        content = path.read_text()
        outside = set(re.findall(r"(?:https?:)?//[a-z][\w.]+", content)) - {"http://www.w3.org"}
        assert not [found for found in outside if found.startswith("http")], path.name
        assert not re.search(
            r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|eval\(", content
        )


def test_every_file_of_the_page_is_served(server: WebServer) -> None:
    for path in PAGE_FOLDER.iterdir():
        assert get(server.url + path.name)[2] == path.read_text()
    assert get(server.url + "../web_server.py")[0] == 404
    assert get(server.url + "map.png")[0] == 404
    assert json.loads(get(server.url + "site.json")[2])["name"] == "no map"


def test_other_host_names_and_origins_are_refused(server: WebServer) -> None:
    assert get(server.url, Host="evil.example")[0] == 403
    assert get(server.url + "live", Origin="http://evil.example")[0] == 403


@pytest.fixture
def open_server() -> Iterator[WebServer]:
    """A server on every address of this computer."""
    watch = Watch(TeamState(), Site(None), lambda: [TROUBLE])
    with closing(WebServer(watch, LiveSource(), "0.0.0.0:0")) as started:
        yield started


def test_page_for_others_answers_to_addresses_and_own_names_only(open_server: WebServer) -> None:
    port = open_server.url.rsplit(":", 1)[1].strip("/")
    for host in ("192.0.2.7", "[2001:db8::1]", socket.gethostname(), "LOCALHOST"):
        assert get(open_server.url, Host=f"{host}:{port}")[0] == 200, host
    for host in ("evil.example", "192.0.2.7.evil.example", "", "[", f"127.0.0.1.{port}"):
        assert get(open_server.url, Host=f"{host}:{port}")[0] in (400, 403), host
    for origin in ("http://evil.example", "null", f"http://192.0.2.7:{port}"):
        assert get(open_server.url + "live", Origin=origin)[0] == 403, origin
        assert get(open_server.url + "site.json", Origin=origin)[0] == 403, origin


def test_acknowledging_takes_the_token_of_the_printed_url(open_server: WebServer) -> None:
    token = open_server.link.partition("?")[2]
    assert re.fullmatch(r"token=[\w-]{20,}", token)

    def acknowledged(query: str) -> bool:
        """Acknowledge the alarm from a page opened with a query; return whether it then is."""
        told: list[bool] = []

        async def acknowledge(page: Page) -> None:
            message = await page.next()
            while not message.get("alarms"):
                message = await page.next()
            await page.socket.send_str('{"acknowledge": 1}')
            for _ in range(5):
                message = await page.next()
            told.append(message["source"]["mayAct"])

        on_a_page(open_server, acknowledge, query)
        (alarm,) = open_server.watch.alarms.alarms()
        assert told == [alarm.acknowledged]
        return alarm.acknowledged

    for query in ("", "token=", "token=guessed", "token=%C3%BC"):
        assert not acknowledged(query), query
    assert acknowledged(token)


class Page:
    """A page that draws every message at once."""

    def __init__(self, socket: aiohttp.ClientWebSocketResponse) -> None:
        self.socket = socket
        self._seen = 0

    async def next(self) -> dict[str, Any]:
        message: dict[str, Any] = await self.socket.receive_json(timeout=10)
        self._seen += 1
        await self.socket.send_json({"seen": self._seen})
        return message

    async def next_part(self, part: str) -> dict[str, Any]:
        """Return the next robot's message that holds a certain part."""
        while True:
            for robot in (await self.next())["robots"]:
                if part in robot:
                    found: dict[str, Any] = robot
                    return found


def on_a_page(server: WebServer, act: Callable[[Page], Awaitable[None]], query: str = "") -> None:
    async def connected() -> None:
        async with (
            aiohttp.ClientSession() as session,
            session.ws_connect(f"{server.url}live?{query}") as socket,
        ):
            await act(Page(socket))

    asyncio.run(connected())


def test_picture_of_an_intruder_is_served_as_a_picture_only(server: WebServer) -> None:
    assert get(server.url + "intruder/1")[0] == 404
    server.watch.team.receive(f"{KEY}/intruder", encode(intruder(1.0)), server.watch.now, START)
    deadline = time.monotonic() + 10.0
    while not (found := [a.number for a in server.watch.alarms.alarms() if a.sighting]):
        assert time.monotonic() < deadline, "no alarm"
        time.sleep(0.02)
    status, headers, _ = get(f"{server.url}intruder/{found[0]}", encoding="latin-1")
    assert (status, headers["Content-Type"]) == (200, "image/jpeg")
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert get(server.url + "intruder/999")[0] == 404
    assert get(server.url + "intruder/x")[0] == 404


def test_shift_log_is_served_filtered_and_as_files() -> None:
    with closing(ShiftLog(None)) as log:
        watch = Watch(TeamState(), Site(None), lambda: [TROUBLE], log.put)
        with closing(WebServer(watch, LiveSource(), "127.0.0.1:0", log)) as server:
            deadline = time.monotonic() + 10.0
            while not json.loads(get(server.url + "log")[2]):
                assert time.monotonic() < deadline, "no entry"
                time.sleep(0.02)
            assert json.loads(get(server.url + "log?least=critical")[2]) == []
            assert json.loads(get(server.url + "log?robot=north/anna&words=BATT")[2]) != []
            _, headers, text = get(server.url + "log.csv")
            assert headers["Content-Disposition"] == 'attachment; filename="shift_log.csv"'
            assert text.splitlines()[1].split(",")[2:6] == [
                *("warning", "north/anna", "battery", "battery at 11.2 V")
            ]
            assert json.loads(get(server.url + "log.json")[2])[0]["text"] == "battery at 11.2 V"
            for query in ("least=worst", "since=nan", "until=noon"):
                assert get(f"{server.url}log?{query}")[0] == 400, query
            assert get(server.url + "log/1.jpg")[0] == 404


def test_messages_hold_only_changed_streams(server: WebServer) -> None:
    async def listen(page: Page) -> None:
        first = await page.next()
        assert first["fresh"]
        assert first["robots"] == []
        team = server.watch.team
        for stream, payload in (("pose", pose(1.0)), ("decision", decision(1.0))):
            team.receive(f"{KEY}/{stream}", encode(payload), server.watch.now)
        parts = await page.next_part("decision")
        assert parts["decision"]["action"] == "keep_going"
        team.receive(f"{KEY}/status", encode(status(1.0)), server.watch.now)
        parts = await page.next_part("status")
        assert "decision" not in parts

    on_a_page(server, listen)


def test_page_that_draws_nothing_gets_two_messages_then_the_newest(
    server: WebServer,
) -> None:
    async def sleep(page: Page) -> None:
        for _ in range(2):
            await page.socket.receive_json(timeout=10)
        team = server.watch.team
        for number in range(50):
            late = decision(1.0, abscissa=float(number))
            team.receive(f"{KEY}/decision", encode(late), server.watch.now)
            await asyncio.sleep(0.01)
        with pytest.raises(TimeoutError):
            await page.socket.receive(timeout=0.2)
        await page.socket.send_json({"seen": 2})
        parts = await page.next_part("decision")
        assert parts["decision"]["abscissa"] == 49.0

    on_a_page(server, sleep)


def test_request_other_than_acknowledging_closes_the_connection(server: WebServer) -> None:
    async def acknowledge(page: Page) -> None:
        await page.socket.send_str('{"acknowledge": 1}')
        while not (await page.next()).get("alarms", [{}])[0].get("acknowledged"):
            pass
        await page.socket.send_str('{"publish": "patrol/north/anna/stop"}')
        while (message := await page.socket.receive(timeout=10)).type != aiohttp.WSMsgType.CLOSE:
            pass
        assert message.data == aiohttp.WSCloseCode.UNSUPPORTED_DATA

    on_a_page(server, acknowledge)


def test_taken_or_invalid_address_is_one_error(server: WebServer) -> None:
    watch = Watch(TeamState(), Site(None))
    taken = server.url.removeprefix("http://").strip("/")
    with pytest.raises(WebError, match=r"Address already in use|address already in use"):
        WebServer(watch, LiveSource(), taken)
    for address in ("8080", "host:port", ":1", "127.0.0.1:99999"):
        with pytest.raises(WebError, match="not an address"):
            WebServer(watch, LiveSource(), address)
