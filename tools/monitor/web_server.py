"""Serves the page and sends every open page its updates.

Runs an event loop on its own thread. A page can acknowledge an alarm and steer a playback, no more,
and only if ``PageAccess`` lets it; nothing is sent on to a robot.
"""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Annotated, Any

import msgspec
from aiohttp import WSCloseCode, WSMessage, WSMsgType, web

from tools.monitor.dial_address import dial_endpoints, reaches_this_computer_only
from tools.monitor.log_routes import LogRoutes
from tools.monitor.page_files import add_page
from tools.monitor.page_message import PageFeed, page_samples
from tools.monitor.page_server import PageServer
from tools.monitor.shift_log import ShiftLog
from tools.monitor.source import Source
from tools.monitor.survey import Survey
from tools.monitor.watch import Watch

PAGE_FOLDER = Path(__file__).parent / "page"
TICK_S = 0.04
"""Period of updates: adds less than half a period of the 10 Hz telemetry to the latency."""
_REQUEST_LIMIT = 4096


class Request(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A request of a page; None: not requested."""

    seen: int | None = None  # number of messages the page has drawn
    acknowledge: int | None = None  # the number of an alarm
    by: Annotated[str, msgspec.Meta(max_length=40)] = ""  # who acknowledges it
    pause: bool | None = None
    speed: float | None = None  # of a playback, times real time
    seek: float | None = None  # s since 1970


_decode_request = msgspec.json.Decoder(Request).decode


class _FlowControl:
    """Flow control of one page: counts messages sent and messages drawn."""

    def __init__(self) -> None:
        self.sent = 0
        self.seen = 0

    @property
    def behind(self) -> bool:
        """Whether more than one message sent is not drawn yet."""
        return self.sent - self.seen > 1


class WebServer:
    """Serves one watch at one address until closed."""

    def __init__(
        self,
        watch: Watch,
        source: Source,
        address: str,
        log: ShiftLog | None = None,
        survey: Survey | None = None,
    ) -> None:
        """Listen on an address such as ``127.0.0.1:8080`` (port 0: any free one).

        log: of the alarms, for the page; None: it offers none. survey: of the recordings played.

        Raises:
            WebError: the address is invalid or taken.
        """
        self.watch = watch
        self.source = source
        self._log = log
        self._survey = survey
        self._ticked = asyncio.Event()
        self._picture = watch.site.picture()
        self._site = msgspec.json.encode(watch.site.description())
        self._server = PageServer(
            address,
            "page's server",
            self._add_routes,
            self._tick,
            request_limit=_REQUEST_LIMIT,
            other="127.0.0.1:8081",
        )
        self._server.start()

    @property
    def url(self) -> str:
        """URL of the page."""
        return self._server.url

    @property
    def link(self) -> str:
        """URL that opens the page with the right to act on it, for whoever reads the terminal."""
        return self._server.link

    def check(self) -> None:
        """Raise RuntimeError if the server has ended by itself."""
        self._server.check()

    def close(self) -> None:
        """Close every page's connection and stop serving; idempotent."""
        self._server.close()

    # --- the loop's thread -----------------------------------------------------------------------

    async def _tick(self) -> None:
        """Advance the watch every ``TICK_S`` until closed."""
        clock = asyncio.get_running_loop()
        due = clock.time()
        while not self._server.ending.is_set():
            self.source.advance(self.watch)
            ticked, self._ticked = self._ticked, asyncio.Event()
            ticked.set()
            due = max(due + TICK_S, clock.time())  # missed ticks are dropped
            await asyncio.sleep(due - clock.time())
        self._ticked.set()

    def _add_routes(self, application: web.Application) -> None:
        add_page(application, PAGE_FOLDER)
        application.router.add_get("/site.json", self._send_site)
        application.router.add_get("/map.png", self._send_picture)
        application.router.add_get(r"/intruder/{number:\d{1,9}}", self._send_intruder)
        application.router.add_get("/live", self._feed_page)
        application.router.add_get("/history", self._send_history)
        application.router.add_get("/dial.json", self._send_dial)
        if self._log is not None:
            LogRoutes(self._log).add_to(application)

    async def _send_site(self, _request: web.Request) -> web.Response:
        return web.Response(body=self._site, content_type="application/json")

    async def _send_picture(self, _request: web.Request) -> web.Response:
        if self._picture is None:
            raise web.HTTPNotFound
        return web.Response(body=self._picture, content_type="image/png")

    async def _send_dial(self, _request: web.Request) -> web.Response:
        """Send what robots dial; the computer's address may change with its network."""
        listen = self.source.listen
        endpoints = await asyncio.to_thread(dial_endpoints, listen) if listen else []
        body = {"endpoints": endpoints, "onlyHere": reaches_this_computer_only(listen)}
        return web.Response(body=msgspec.json.encode(body), content_type="application/json")

    async def _send_history(self, _request: web.Request) -> web.Response:
        """Send the surveyed samples of every robot, as the page gets those of the present."""
        histories = {} if self._survey is None else self._survey.histories
        body = {robot: page_samples(samples) for robot, samples in histories.items()}
        return web.Response(body=msgspec.json.encode(body), content_type="application/json")

    async def _send_intruder(self, request: web.Request) -> web.Response:
        """Send the picture of an alarm's intruder."""
        alarm = self.watch.alarms.alarm(int(request.match_info["number"]))
        if alarm is None or alarm.sighting is None or not alarm.sighting.picture:
            raise web.HTTPNotFound
        return web.Response(body=alarm.sighting.picture, content_type="image/jpeg")

    async def _feed_page(self, request: web.Request) -> web.WebSocketResponse:
        """Send one page its updates until it disconnects; a slow page gets fewer, not older ones.

        Requests to act are ignored without the token.
        """
        may_act = self._server.access.may_act(request.query.get("token", ""))
        socket = web.WebSocketResponse(heartbeat=10.0, max_msg_size=_REQUEST_LIMIT, compress=False)
        await socket.prepare(request)
        flow = _FlowControl()
        listening = asyncio.create_task(self._listen(socket, flow, may_act=may_act))
        try:
            await self._feed(socket, flow, may_act=may_act)
        except ConnectionError:
            pass  # the page is closed, or reconnects by itself
        finally:
            listening.cancel()
            await socket.close()
        return socket

    async def _feed(
        self, socket: web.WebSocketResponse, flow: _FlowControl, *, may_act: bool
    ) -> None:
        feed, epoch = PageFeed(self.watch), self.source.epoch
        fresh = True
        while not socket.closed and not self._server.ending.is_set():
            if epoch != self.source.epoch:
                feed, epoch, fresh = PageFeed(self.watch), self.source.epoch, True
            source = {**self.source.description(), "mayAct": may_act}
            log = None if self._log is None else self._log.version
            surveyed = self._survey is not None and self._survey.done
            extra: dict[str, Any] = {"source": source, "fresh": fresh, "log": log}
            extra["surveyed"] = surveyed
            await socket.send_str(feed.message(extra).decode())
            flow.sent += 1
            fresh = False
            await self._ticked.wait()
            while flow.behind and not socket.closed and not self._server.ending.is_set():
                await self._ticked.wait()

    async def _listen(
        self, socket: web.WebSocketResponse, flow: _FlowControl, *, may_act: bool
    ) -> None:
        """Execute a page's requests; an invalid one closes the connection."""
        async for message in socket:
            request = _decoded(message)
            if request is None:
                await socket.close(code=WSCloseCode.UNSUPPORTED_DATA)
                return
            flow.seen = request.seen or flow.seen
            if not may_act:
                continue
            if request.acknowledge is not None:
                self.watch.alarms.acknowledge(request.acknowledge, request.by, self.watch.wall)
            self.source.steer(pause=request.pause, speed=request.speed, seek=request.seek)


def _decoded(message: WSMessage) -> Request | None:
    """Return a message's request, or None if it is invalid."""
    if message.type is not WSMsgType.TEXT:
        return None
    try:
        return _decode_request(message.data)
    except msgspec.DecodeError:
        return None
