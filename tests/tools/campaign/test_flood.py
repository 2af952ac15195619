"""The flood at an operator's endpoint."""

import socket
from contextlib import closing

from tools.campaign.flood import Flood
from tools.monitor.endpoint import free_endpoint


def test_every_client_is_flooded_until_close() -> None:
    endpoint = free_endpoint()
    host, _, port = endpoint.removeprefix("tcp/").rpartition(":")
    with (
        closing(Flood(endpoint)),
        socket.create_connection((host, int(port)), timeout=10.0) as victim,
    ):
        received = 0
        while received < 200_000:
            received += len(victim.recv(65536))
    with socket.socket() as late:
        assert late.connect_ex((host, int(port))) != 0
