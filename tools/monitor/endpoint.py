"""Loopback endpoints for robots and operator on one machine."""

from __future__ import annotations

import socket


def free_endpoint() -> str:
    """Return a Zenoh endpoint on a loopback port that is free at present."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        return f"tcp/127.0.0.1:{server.getsockname()[1]}"
