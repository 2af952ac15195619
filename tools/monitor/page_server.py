"""Serves one page's application at one address, on a thread of its own, until closed."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from concurrent.futures import Future

from aiohttp import web

from tools.monitor.lasting_thread import LastingThread
from tools.monitor.page_access import PageAccess
from tools.monitor.page_files import HEADERS


class WebError(ValueError):
    """The address cannot be served; the message names address, reason and remedy."""


class PageServer:
    """The server of a page: its thread, its address and its guard.

    ``access``: who may act. ``ending``: set when the page is to end, for its own handlers.
    """

    def __init__(
        self,
        address: str,
        name: str,
        add_routes: Callable[[web.Application], None],
        work: Callable[[], Awaitable[object]],
        *,
        request_limit: int,
        other: str,
    ) -> None:
        """Take an address such as ``127.0.0.1:8080`` (port 0: any free one); ``start`` listens.

        name: of the thread, for people. add_routes: gives the application its routes. work: runs
        in the server's loop until ``ending``. request_limit: bytes. other: address to propose where
        this one is taken. Raises WebError: the address is invalid.
        """
        self._address, self._other = address, other
        self._host, self._port = parsed_address(address, "--http")
        self.access = PageAccess(self._host)
        self.ending = asyncio.Event()
        self._application = web.Application(
            middlewares=[self._guard], client_max_size=request_limit
        )
        add_routes(self._application)
        self._work = work
        self._name = name
        self._loop = asyncio.new_event_loop()
        self._thread: LastingThread | None = None

    def start(self) -> None:
        """Listen. Raises WebError: the address is taken."""
        ready: Future[int] = Future()
        self._thread = LastingThread(lambda: self._run(ready), self._name)
        try:
            self._port = ready.result()
        except OSError as error:
            self._thread.join()
            raise WebError(
                f"cannot serve the page on {self._address}: {error.strerror}; "
                f"give a free address, e.g. --http {self._other}"
            ) from error

    @property
    def url(self) -> str:
        """URL of the page."""
        host = f"[{self._host}]" if ":" in self._host else self._host
        return f"http://{host}:{self._port}/"

    @property
    def link(self) -> str:
        """URL that opens the page with the right to act on it, for whoever reads the terminal."""
        return f"{self.url}?token={self.access.token}" if self.access.token else self.url

    def check(self) -> None:
        """Raise RuntimeError if the server has ended by itself."""
        if self._thread is not None:
            self._thread.check()

    def close(self) -> None:
        """Close every page's connection and stop serving; idempotent."""
        if self._thread is not None and self._thread.is_alive():
            self._loop.call_soon_threadsafe(self.ending.set)
            self._thread.join()

    # --- the loop's thread -----------------------------------------------------------------------

    def _run(self, ready: Future[int]) -> None:
        with asyncio.Runner(loop_factory=lambda: self._loop) as runner:
            runner.run(self._serve(ready))

    async def _serve(self, ready: Future[int]) -> None:
        runner = web.AppRunner(self._application, access_log=None, shutdown_timeout=1.0)
        await runner.setup()
        try:
            await web.TCPSite(runner, self._host, self._port).start()
        except OSError as error:
            await runner.cleanup()
            ready.set_exception(error)
            return
        ready.set_result(runner.addresses[0][1])
        await self._work()
        await runner.cleanup()

    @web.middleware
    async def _guard(
        self, request: web.Request, handler: Callable[[web.Request], Awaitable[web.StreamResponse]]
    ) -> web.StreamResponse:
        """Add security headers; refuse foreign host names and other sites' pages with 403."""
        refusal = self.access.refusal(request.host, request.headers.get("Origin"))
        if refusal:
            raise web.HTTPForbidden(text=refusal)
        response = await handler(request)
        if not response.prepared:
            response.headers.update(HEADERS)
        return response


def parsed_address(address: str, option: str) -> tuple[str, int]:
    """Return host and port of an address; raises WebError, naming the option, if invalid."""
    host, _, port = address.rpartition(":")
    if not host or not port.isdecimal() or int(port) > 65535:
        raise WebError(f"{option} {address}: not an address; give host:port, e.g. 127.0.0.1:8080")
    return host.strip("[]"), int(port)
