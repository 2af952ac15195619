"""Serves the page on which a border and zones are drawn, judges each draft and saves it.

The page draws and asks; all geometry is computed here, by the code that robots and ``patrol map
check`` use. A border file that is there when one is saved is kept beside it.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any, TypeVar

import msgspec
from aiohttp import web

from maps.border import BorderError
from maps.clearance import NEEDED_CLEARANCE
from maps.occupancy_map import MapError, OccupancyMap
from maps.zone import Zone, ZoneError
from maps.zone_file import ZONES_FILE, ZoneEntries, load_zones, read_zones, zones_text
from tools.border_editor.border_draft import BorderDraft, read_draft, save_draft
from tools.border_editor.draft_judgement import judge
from tools.border_editor.kept_file import write_kept
from tools.border_editor.roomy_places import RoomyPlaces
from tools.border_editor.suggested_loop import suggest_loop
from tools.monitor.page_files import add_file, add_page
from tools.monitor.page_server import PageServer
from tools.monitor.site import page_extent, page_picture
from tools.monitor.web_server import PAGE_FOLDER as MONITOR_PAGE

PAGE_FOLDER = Path(__file__).parent / "page"
_REQUEST_LIMIT = 900_000  # bytes; the longest border, or as many zones as a file may hold

_T = TypeVar("_T")


class Place(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A place on the map, m in the map frame."""

    x: float
    y: float


class EditorServer:
    """Serves one border of one map folder at one address until closed."""

    def __init__(self, file: Path, occupancy: OccupancyMap, address: str) -> None:
        """Listen on an address such as ``127.0.0.1:8090`` (port 0: any free one).

        file: the border's, in the map's folder; it may be missing or broken.
        Raises WebError: the address is invalid or taken.
        """
        self.file = file
        self._map = occupancy
        self._roomy = RoomyPlaces(occupancy, NEEDED_CLEARANCE)
        self._picture = page_picture(occupancy)
        self._server = PageServer(
            address,
            "border editor's server",
            self._add_routes,
            self._until_closed,
            request_limit=_REQUEST_LIMIT,
            other="127.0.0.1:8091",
        )
        self._server.start()

    @property
    def link(self) -> str:
        """URL of the page, with the token that saving needs where others can reach it."""
        return self._server.link

    def check(self) -> None:
        """Raise RuntimeError if the server has ended by itself."""
        self._server.check()

    def close(self) -> None:
        """Stop serving; idempotent."""
        self._server.close()

    # --- the loop's thread -----------------------------------------------------------------------

    async def _until_closed(self) -> None:
        await self._server.ending.wait()

    def _add_routes(self, application: web.Application) -> None:
        application.middlewares.append(self._guard)
        add_page(application, PAGE_FOLDER)
        add_file(application, MONITOR_PAGE / "viewport.js")
        add_file(application, MONITOR_PAGE / "icon.svg")
        application.router.add_get("/site.json", self._send_site)
        application.router.add_get("/map.png", self._send_picture)
        application.router.add_post("/judge", self._judge)
        application.router.add_post("/snap", self._snap)
        application.router.add_post("/suggest", self._suggest)
        application.router.add_post("/save", self._save)
        application.router.add_post("/zones", self._save_zones)

    @web.middleware
    async def _guard(
        self, request: web.Request, handler: Callable[[web.Request], Awaitable[web.StreamResponse]]
    ) -> web.StreamResponse:
        """Refuse drafts without the token with 403."""
        may_act = self._server.access.may_act(request.query.get("token", ""))
        if request.method == "POST" and not may_act:
            raise web.HTTPForbidden(text="open the page by the URL that patrol map border printed")
        return await handler(request)

    async def _send_site(self, _request: web.Request) -> web.Response:
        draft, trouble = read_draft(self.file)
        zones: tuple[Zone, ...] = ()
        try:
            zones = load_zones(self.file.parent)
        except (MapError, ZoneError) as error:
            trouble = trouble or f"{error}; saving zones replaces it"
        return _answer(
            {
                "name": self.file.parent.resolve().name,
                "file": str(self.file),
                "map": page_extent(self._map),
                "needed": NEEDED_CLEARANCE,
                "draft": draft,
                "zones": [{"name": zone.name, "polygon": zone.polygon} for zone in zones],
                "trouble": trouble,
            }
        )

    async def _send_picture(self, _request: web.Request) -> web.Response:
        return web.Response(body=self._picture, content_type="image/png")

    async def _judge(self, request: web.Request) -> web.Response:
        draft = await _content(request, BorderDraft)
        judgement = judge(self._map, draft, NEEDED_CLEARANCE)
        return _answer({**msgspec.to_builtins(judgement), "ok": judgement.ok})

    async def _snap(self, request: web.Request) -> web.Response:
        """Answer with the nearest place that has room; with the place itself if none has."""
        place = await _content(request, Place)
        x, y = self._roomy.nearest(place.x, place.y) or (place.x, place.y)
        return _answer({"x": x, "y": y})

    async def _suggest(self, _request: web.Request) -> web.Response:
        """Answer with the draft of a loop, null if there is none."""
        return _answer(await asyncio.to_thread(suggest_loop, self._map, NEEDED_CLEARANCE))

    async def _save(self, request: web.Request) -> web.Response:
        draft = await _content(request, BorderDraft)
        try:
            save_draft(draft, self.file)
        except BorderError as error:
            return _answer({"saved": False, "why": str(error).removeprefix("this border: ")})
        except OSError as error:
            return _answer({"saved": False, "why": f"{self.file}: {error.strerror}"})
        return _answer({"saved": True, "why": ""})

    async def _save_zones(self, request: web.Request) -> web.Response:
        entries = await _content(request, ZoneEntries)
        path = self.file.with_name(ZONES_FILE)
        try:
            text = zones_text([Zone(each.name, tuple(each.polygon)) for each in entries.zone])
            read_zones(text.encode(), "zones")
            write_kept(path, text)
        except ZoneError as error:
            return _answer({"saved": False, "why": str(error).removeprefix("zones: ")})
        except OSError as error:
            return _answer({"saved": False, "why": f"{path}: {error.strerror}"})
        return _answer({"saved": True, "why": ""})


async def _content(request: web.Request, kind: type[_T]) -> _T:
    try:
        return msgspec.json.decode(await request.read(), type=kind)
    except msgspec.DecodeError as error:
        raise web.HTTPBadRequest(text=str(error)) from error


def _answer(content: Any) -> web.Response:
    return web.Response(body=msgspec.json.encode(content), content_type="application/json")
