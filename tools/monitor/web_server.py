"""Serves the page and keeps every page that is open up to date.

Runs an event loop on a thread of its own. The page can do two things here, acknowledge an alarm
and steer a playback; nothing it or anybody says reaches a robot.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Awaitable, Callable
from concurrent.futures import Future
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import msgspec
from aiohttp import WSCloseCode, WSMessage, WSMsgType, web

from tools.monitor.page_message import PageFeed
from tools.monitor.source import Source
from tools.monitor.watch import Watch

PAGE_FOLDER = Path(__file__).parent / "page"
TICK_S = 0.04
"""Telemetry comes ten times a second: waiting half of that at most costs little time or power."""
_REQUEST_LIMIT = 4096
_TYPES = {
    ".html": "text/html",
    ".js": "text/javascript",
    ".css": "text/css",
    ".svg": "image/svg+xml",
}
_HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
        "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
_LOOPBACK = ("localhost", "127.0.0.1", "::1")


class WebError(ValueError):
    """The page cannot be served; the message names address, reason and remedy."""


class Request(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What a page may ask for."""

    seen: int | None = None  # how many messages the page has shown
    acknowledge: int | None = None  # the number of an alarm
    pause: bool | None = None
    speed: float | None = None  # of a playback, times real time
    seek: float | None = None  # s since 1970


_decode_request = msgspec.json.Decoder(Request).decode


class _Pace:
    """How far a page has kept up with what it was sent."""

    def __init__(self) -> None:
        self.sent = 0
        self.seen = 0

    @property
    def behind(self) -> bool:
        """Whether the page has yet to show more than one message."""
        return self.sent - self.seen > 1


class WebServer:
    """Serves one watch at one address, until closed."""

    def __init__(self, watch: Watch, source: Source, address: str) -> None:
        """Listen on an address such as ``127.0.0.1:8080`` (port 0: any free one).

        Raises:
            WebError: the address is not one, or is taken.
        """
        self.watch = watch
        self.source = source
        self._host, self._port = parsed_address(address, "--http")
        self._ticked = asyncio.Event()
        self._picture = watch.site.picture()
        self._site = msgspec.json.encode(watch.site.description())
        self._ending = asyncio.Event()
        self._loop = asyncio.new_event_loop()
        ready: Future[int] = Future()
        self._thread = threading.Thread(target=self._run, args=(ready,), name="page", daemon=True)
        self._thread.start()
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
        """Where the page is."""
        host = f"[{self._host}]" if ":" in self._host else self._host
        return f"http://{host}:{self._port}/"

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
        """Serve until told to end, looking at the team 25 times a second."""
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
            due = max(due + TICK_S, self._loop.time())  # what was missed is not made up for
            await asyncio.sleep(due - self._loop.time())
        self._ticked.set()
        await runner.cleanup()

    def _application(self) -> web.Application:
        application = web.Application(middlewares=[self._guard], client_max_size=_REQUEST_LIMIT)
        application.router.add_get("/", _file_handler(PAGE_FOLDER / "index.html"))
        for path in sorted(PAGE_FOLDER.iterdir()):
            if path.suffix in _TYPES:
                application.router.add_get(f"/{path.name}", _file_handler(path))
        application.router.add_get("/site.json", self._send_site)
        application.router.add_get("/map.png", self._send_picture)
        application.router.add_get("/live", self._feed_page)
        return application

    @web.middleware
    async def _guard(
        self, request: web.Request, handler: Callable[[web.Request], Awaitable[web.StreamResponse]]
    ) -> web.StreamResponse:
        """Refuse names that are not ours (a page elsewhere that resolves to us); add headers."""
        if self._host in _LOOPBACK and _host_name(request.host) not in _LOOPBACK:
            raise web.HTTPForbidden(text="this page is served to this computer only")
        response = await handler(request)
        if not response.prepared:
            response.headers.update(_HEADERS)
        return response

    async def _send_site(self, _request: web.Request) -> web.Response:
        return web.Response(body=self._site, content_type="application/json")

    async def _send_picture(self, _request: web.Request) -> web.Response:
        if self._picture is None:
            raise web.HTTPNotFound
        return web.Response(body=self._picture, content_type="image/png")

    async def _feed_page(self, request: web.Request) -> web.WebSocketResponse:
        """Send one page what changes, until it goes away; a slow page gets fewer messages."""
        origin = request.headers.get("Origin")
        if origin is not None and urlsplit(origin).netloc != request.host:
            raise web.HTTPForbidden(text="only this page may listen here")
        socket = web.WebSocketResponse(heartbeat=10.0, max_msg_size=_REQUEST_LIMIT, compress=False)
        await socket.prepare(request)
        pace = _Pace()
        listening = asyncio.create_task(self._listen(socket, pace))
        try:
            await self._feed(socket, pace)
        except ConnectionError:
            pass  # the page is gone; it comes back by itself if anybody still looks at it
        finally:
            listening.cancel()
            await socket.close()
        return socket

    async def _feed(self, socket: web.WebSocketResponse, pace: _Pace) -> None:
        feed, epoch = PageFeed(self.watch), self.source.epoch
        fresh = True
        while not socket.closed and not self._ending.is_set():
            if epoch != self.source.epoch:
                feed, epoch, fresh = PageFeed(self.watch), self.source.epoch, True
            extra: dict[str, Any] = {"source": self.source.description(), "fresh": fresh}
            await socket.send_str(feed.message(extra).decode())
            pace.sent += 1
            fresh = False
            await self._ticked.wait()
            while pace.behind and not socket.closed and not self._ending.is_set():
                await self._ticked.wait()

    async def _listen(self, socket: web.WebSocketResponse, pace: _Pace) -> None:
        """Do what a page asks for; one that asks for anything else is shown out."""
        async for message in socket:
            request = _decoded(message)
            if request is None:
                await socket.close(code=WSCloseCode.UNSUPPORTED_DATA)
                return
            pace.seen = request.seen or pace.seen
            if request.acknowledge is not None:
                self.watch.alarms.acknowledge(request.acknowledge)
            self.source.steer(pause=request.pause, speed=request.speed, seek=request.seek)


def _decoded(message: WSMessage) -> Request | None:
    """Return what a message asks for, or None if it is no request."""
    if message.type is not WSMsgType.TEXT:
        return None
    try:
        return _decode_request(message.data)
    except msgspec.DecodeError:
        return None


def _file_handler(path: Path) -> Callable[[web.Request], Awaitable[web.Response]]:
    content, kind = path.read_bytes(), _TYPES[path.suffix]

    async def send(_request: web.Request) -> web.Response:
        return web.Response(body=content, content_type=kind, charset="utf-8")

    return send


def parsed_address(address: str, option: str) -> tuple[str, int]:
    """Return host and port of an option's address; WebError if it is none."""
    host, _, port = address.rpartition(":")
    if not host or not port.isdecimal() or int(port) > 65535:
        raise WebError(f"{option} {address}: not an address; give host:port, e.g. 127.0.0.1:8080")
    return host.strip("[]"), int(port)


def _host_name(host: str) -> str:
    """Return a Host header's name without port and brackets."""
    return (urlsplit(f"//{host}").hostname or "").lower()
