"""An emulated port that runs in real time beside a test."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext

from drivers.emulation.port import PtyPort, TcpPort


@contextmanager
def pumped(
    port: PtyPort | TcpPort, lock: AbstractContextManager[object] | None = None
) -> Iterator[str]:
    """Run an emulated port in real time, under a lock if there is one; yields its URL."""
    done, held = threading.Event(), lock or nullcontext()

    def pump() -> None:
        while not done.wait(0.002):
            with held:
                port.pump(time.monotonic())

    thread = threading.Thread(target=pump)
    thread.start()
    try:
        yield port.url
    finally:
        done.set()
        thread.join()
        port.close()
