"""What robots dial to reach this monitor, for whoever sets one up."""

from __future__ import annotations

import socket
from ipaddress import ip_address

_ANY = ("0.0.0.0", "[::]", "::")  # noqa: S104 — recognised, not listened on
_OUTSIDE = ("192.0.2.1", 9)
"""A place in no network (RFC 5737): connecting to it chooses a way out, and sends nothing."""


def dial_endpoints(listen: str) -> list[str]:
    """Return the endpoints, such as ``tcp/192.168.1.10:7447``, under which one is reached.

    listen: the Zenoh endpoint listened on; the address of every network stands for this computer's
    own, first by number, then by name. Endpoints of this computer only are returned as they are.
    """
    protocol, _, address = listen.partition("/")
    host, _, port = address.rpartition(":")
    if host not in _ANY:
        return [listen]
    own = _own_address()
    names = [own] if own else []
    return [f"{protocol}/{name}:{port}" for name in (*names, socket.gethostname())]


def reaches_this_computer_only(listen: str) -> bool:
    """Return whether an endpoint listened on cannot be reached from other computers."""
    host = listen.partition("/")[2].rpartition(":")[0].strip("[]")
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _own_address() -> str:
    """Return this computer's address on the way to other networks; empty without any."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(_OUTSIDE)
        except OSError:
            return ""
        return str(probe.getsockname()[0])
