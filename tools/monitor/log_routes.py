"""What the page's server answers about the shift log: its entries, as a file too, and pictures."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Mapping

from aiohttp import web

from tools.monitor.alarm import Severity
from tools.monitor.log_export import log_csv, log_json
from tools.monitor.shift_log import KEPT, LogEntry, LogFilter, ShiftLog

SHOWN = 500
"""Entries sent to a page; a file has all."""
_WORDS = 100


class LogRoutes:
    """The routes of one log. Whoever may read the page may read them."""

    def __init__(self, log: ShiftLog) -> None:
        self._log = log

    def add_to(self, application: web.Application) -> None:
        """Add the routes ``/log``, ``/log.csv``, ``/log.json`` and ``/log/ID.jpg``."""
        application.router.add_get("/log", self._send_entries)
        application.router.add_get("/log.csv", self._send_csv)
        application.router.add_get("/log.json", self._send_json)
        application.router.add_get(r"/log/{entry:\d{1,9}}.jpg", self._send_picture)

    async def _send_entries(self, request: web.Request) -> web.Response:
        body = log_json(await self._wanted(request, SHOWN))
        return web.Response(body=body, content_type="application/json")

    async def _send_csv(self, request: web.Request) -> web.Response:
        text = log_csv(await self._wanted(request, KEPT))
        return _file(text.encode(), "text/csv", "shift_log.csv")

    async def _send_json(self, request: web.Request) -> web.Response:
        body = log_json(await self._wanted(request, KEPT))
        return _file(body, "application/json", "shift_log.json")

    async def _send_picture(self, request: web.Request) -> web.Response:
        entry = int(request.match_info["entry"])
        picture = await asyncio.to_thread(self._log.picture, entry)
        if not picture:
            raise web.HTTPNotFound
        return web.Response(body=picture, content_type="image/jpeg")

    async def _wanted(self, request: web.Request, limit: int) -> list[LogEntry]:
        wanted = filter_of(request.query)
        return await asyncio.to_thread(self._log.entries, wanted, limit)


def filter_of(query: Mapping[str, str]) -> LogFilter:
    """Return the filter of a URL's query; raises HTTPBadRequest for one that is none."""
    try:
        return LogFilter(
            words=query.get("words", "")[:_WORDS],
            robot=query.get("robot", "")[:_WORDS],
            least=Severity[query.get("least", "info").upper()],
            since=_time(query, "since"),
            until=_time(query, "until"),
        )
    except (KeyError, ValueError) as error:
        raise web.HTTPBadRequest(text=f"not a filter: {error}") from None


def _time(query: Mapping[str, str], key: str) -> float | None:
    if not query.get(key):
        return None
    value = float(query[key])
    if not math.isfinite(value):
        raise ValueError(key)
    return value


def _file(body: bytes, kind: str, name: str) -> web.Response:
    headers = {"Content-Disposition": f'attachment; filename="{name}"'}
    return web.Response(body=body, content_type=kind, charset="utf-8", headers=headers)
