"""Who may read the page, and who may act on it.

Served to this computer only, the page answers to loopback's names, and whoever reads may act.
Served to others, it answers to literal addresses and to this computer's own names, so that a
foreign site whose name is made to point here (DNS rebinding) reads nothing; and acting takes the
token that the monitor prints as part of the page's URL.
"""

from __future__ import annotations

import secrets
import socket
from ipaddress import ip_address
from urllib.parse import urlsplit

_LOOPBACK = ("localhost", "127.0.0.1", "::1")
_TOKEN_BYTES = 16


class PageAccess:
    """The rules for one address that the page is served on."""

    def __init__(self, host: str) -> None:
        self._local = host in _LOOPBACK
        self.token = "" if self._local else secrets.token_urlsafe(_TOKEN_BYTES)
        """What acting takes; empty: nothing."""
        own = socket.gethostname().lower()
        self._names = {"localhost", own, f"{own}.local", socket.getfqdn().lower()}

    def refusal(self, host: str, origin: str | None) -> str:
        """Return why a request with these Host and Origin headers is refused; empty if it is not.

        origin: None if the request has none, as those of no page.
        """
        if not self._answers_to(_name(host)):
            return "this page is not served under that name"
        if origin is not None and urlsplit(origin).netloc.lower() != host.lower():
            return "only this page may listen here"
        return ""

    def may_act(self, token: str) -> bool:
        """Return whether a page that gives a token may acknowledge alarms and steer a playback."""
        return secrets.compare_digest(token.encode(), self.token.encode())

    def _answers_to(self, name: str) -> bool:
        if self._local:
            return name in _LOOPBACK
        return name in self._names or _is_address(name)


def _name(host: str) -> str:
    """Return a Host header's name in lower case, without port and brackets; empty if invalid."""
    try:
        return (urlsplit(f"//{host}").hostname or "").lower()
    except ValueError:
        return ""


def _is_address(name: str) -> bool:
    try:
        ip_address(name)
    except ValueError:
        return False
    return True
