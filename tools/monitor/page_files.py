"""The files of a page, as a web application serves them."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from pathlib import Path

from aiohttp import web

_TYPES = {
    ".html": "text/html",
    ".js": "text/javascript",
    ".css": "text/css",
    ".svg": "image/svg+xml",
}
HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
        "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
"""Of every response: nothing of another site is loaded, and nothing is kept."""


def add_page(application: web.Application, folder: Path) -> None:
    """Serve a folder's page, ``index.html`` at ``/`` and its files by their names."""
    application.router.add_get("/", _file_handler(folder / "index.html"))
    for path in sorted(folder.iterdir()):
        if path.suffix in _TYPES:
            add_file(application, path)


def add_file(application: web.Application, path: Path) -> None:
    """Serve one file by its name."""
    application.router.add_get(f"/{path.name}", _file_handler(path))


def _file_handler(path: Path) -> Callable[[web.Request], Awaitable[web.Response]]:
    content, kind = path.read_bytes(), _TYPES[path.suffix]

    async def send(_request: web.Request) -> web.Response:
        return web.Response(body=content, content_type=kind, charset="utf-8")

    return send
