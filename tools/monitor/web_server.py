"""Serves the page and sends every open page its updates.

Runs an event loop on its own thread. A page can acknowledge an alarm and steer a playback, no more,
and only if ``PageAccess`` lets it; nothing is sent on to a robot.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import msgspec
from aiohttp import WSCloseCode, WSMessage, WSMsgType, web

from tools.monitor.lasting_thread import LastingThread
from tools.monitor.page_access import PageAccess
from tools.monitor.page_files import HEADERS, add_page
from tools.monitor.page_message import PageFeed
from tools.monitor.source import Source
from tools.monitor.watch import Watch

PAGE_FOLDER = Path(__file__).parent / "page"
TICK_S = 0.04
"""Period of updates: adds less than half a period of the 10 Hz telemetry to the latency."""
_REQUEST_LIMIT = 4096


class WebError(ValueError):
    """The address cannot be served; the message names address, reason and remedy."""


class Request(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A request of a page; None: not requested."""

    seen: int | None = None  # number of messages the page has drawn
    acknowledge: int | None = None  # the number of an alarm
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

    def __init__(self, watch: Watch, source: Source, address: str) -> None:
        """Listen on an address such as ``127.0.0.1:8080`` (port 0: any free one).

        Raises:
            WebError: the address is invalid or taken.
        """
        self.watch = watch
        self.source = source
        self._host, self._port = parsed_address(address, "--http")
        self._access = PageAccess(self._host)
        self._ticked = asyncio.Event()
        self._picture = watch.site.picture()
        self._site = msgspec.json.encode(watch.site.description())
        self._ending = asyncio.Event()
        self._loop = asyncio.new_event_loop()
        ready: Future[int] = Future()
        self._thread = LastingThread(lambda: self._run(ready), "page's server")
        try:
            self._port = ready.result()
        except OSError as error:
            self._thread.join()
            raise WebError(
                f"cannot serve the page on {address}: {error.strerror}; "
                "give a free address, e.g. --http 127.0.0.1:8081"
            ) from error

    @property
    def url(self) -> str:
        """URL of the page."""
        host = f"[{self._host}]" if ":" in self._host else self._host
        return f"http://{host}:{self._port}/"

    @property
    def link(self) -> str:
        """URL that opens the page with the right to act on it, for whoever reads the terminal."""
        return f"{self.url}?token={self._access.token}" if self._access.token else self.url

    def check(self) -> None:
        """Raise RuntimeError if the server has ended by itself."""
        self._thread.check()

    def close(self) -> None:
        """Close every page's connection and stop serving; idempotent."""
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._ending.set)
            self._thread.join()

    # --- the loop's thread -----------------------------------------------------------------------

    def _run(self, ready: Future[int]) -> None:
        with asyncio.Runner(loop_factory=lambda: self._loop) as runner:
            runner.run(self._serve(ready))

    async def _serve(self, ready: Future[int]) -> None:
        """Serve until closed, advancing the watch every ``TICK_S``."""
        runner = web.AppRunner(self._application(), access_log=None, shutdown_timeout=1.0)
        await runner.setup()
        try:
            site = web.TCPSite(runner, self._host, self._port)
            await site.start()
        except OSError as error:
            await runner.cleanup()
            ready.set_exception(error)
            return
        ready.set_result(runner.addresses[0][1])
        due = self._loop.time()
        while not self._ending.is_set():
            self.source.advance(self.watch)
            ticked, self._ticked = self._ticked, asyncio.Event()
            ticked.set()
            due = max(due + TICK_S, self._loop.time())  # missed ticks are dropped
            await asyncio.sleep(due - self._loop.time())
        self._ticked.set()
        await runner.cleanup()

    def _application(self) -> web.Application:
        application = web.Application(middlewares=[self._guard], client_max_size=_REQUEST_LIMIT)
        add_page(application, PAGE_FOLDER)
        application.router.add_get("/site.json", self._send_site)
        application.router.add_get("/map.png", self._send_picture)
        application.router.add_get("/live", self._feed_page)
        return application

    @web.middleware
    async def _guard(
        self, request: web.Request, handler: Callable[[web.Request], Awaitable[web.StreamResponse]]
    ) -> web.StreamResponse:
        """Add security headers; refuse foreign host names and other sites' pages with 403."""
        refusal = self._access.refusal(request.host, request.headers.get("Origin"))
        if refusal:
            raise web.HTTPForbidden(text=refusal)
        response = await handler(request)
        if not response.prepared:
            response.headers.update(HEADERS)
        return response

    async def _send_site(self, _request: web.Request) -> web.Response:
        return web.Response(body=self._site, content_type="application/json")

    async def _send_picture(self, _request: web.Request) -> web.Response:
        if self._picture is None:
            raise web.HTTPNotFound
        return web.Response(body=self._picture, content_type="image/png")

    async def _feed_page(self, request: web.Request) -> web.WebSocketResponse:
        """Send one page its updates until it disconnects; a slow page gets fewer, not older ones.

        Requests to act are ignored without the token.
        """
        may_act = self._access.may_act(request.query.get("token", ""))
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
        while not socket.closed and not self._ending.is_set():
            if epoch != self.source.epoch:
                feed, epoch, fresh = PageFeed(self.watch), self.source.epoch, True
            source = {**self.source.description(), "mayAct": may_act}
            extra: dict[str, Any] = {"source": source, "fresh": fresh}
            await socket.send_str(feed.message(extra).decode())
            flow.sent += 1
            fresh = False
            await self._ticked.wait()
            while flow.behind and not socket.closed and not self._ending.is_set():
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
                self.watch.alarms.acknowledge(request.acknowledge)
            self.source.steer(pause=request.pause, speed=request.speed, seek=request.seek)


def _decoded(message: WSMessage) -> Request | None:
    """Return a message's request, or None if it is invalid."""
    if message.type is not WSMsgType.TEXT:
        return None
    try:
        return _decode_request(message.data)
    except msgspec.DecodeError:
        return None


def parsed_address(address: str, option: str) -> tuple[str, int]:
    """Return host and port of an address; raises WebError, naming the option, if invalid."""
    host, _, port = address.rpartition(":")
    if not host or not port.isdecimal() or int(port) > 65535:
        raise WebError(f"{option} {address}: not an address; give host:port, e.g. 127.0.0.1:8080")
    return host.strip("[]"), int(port)
