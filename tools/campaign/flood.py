"""A server at the operator's endpoint that sends garbage to every robot that connects."""

from __future__ import annotations

import contextlib
import random
import socket
import threading

_PATIENCE_S = 0.2


class Flood:
    """Listens at a Zenoh endpoint ``tcp/HOST:PORT`` and floods each client until ``close``."""

    def __init__(self, endpoint: str) -> None:
        """Listen at the endpoint, which must be free."""
        host, _, port = endpoint.removeprefix("tcp/").rpartition(":")
        self._listener = socket.create_server((host, int(port)), reuse_port=False)
        self._listener.settimeout(_PATIENCE_S)
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run, name="flood", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the flood and close the endpoint."""
        self._ending.set()
        self._thread.join()
        self._listener.close()

    def _run(self) -> None:
        garbage = random.Random(1).randbytes(65536)  # noqa: S311 - any bytes will do
        while not self._ending.is_set():
            with contextlib.suppress(OSError):
                client, _ = self._listener.accept()
                with client:
                    client.settimeout(_PATIENCE_S)
                    while not self._ending.is_set():
                        client.send(garbage)
