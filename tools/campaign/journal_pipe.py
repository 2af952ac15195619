"""The agent's standard error as a service has it: a pipe, which can be made to hang."""

from __future__ import annotations

import os
import threading
from contextlib import suppress
from pathlib import Path

_BLOCK = 4096


class JournalPipe:
    """A pipe whose lines are copied to a file by a thread; ``end`` is where the agent writes."""

    def __init__(self, log: Path) -> None:
        self._reader, self.end = os.pipe()
        self._reads = threading.Event()
        self._reads.set()
        self._paused = threading.Event()
        self._thread = threading.Thread(target=self._copy, args=(log,), daemon=True)
        self._thread.start()

    def hang(self) -> None:
        """Take no more lines and fill the pipe, so that the next line written waits."""
        self._reads.clear()
        os.write(self.end, b"\0")  # ends a read that has begun, and would make room later
        self._paused.wait()
        os.set_blocking(self.end, False)
        with suppress(BlockingIOError):
            while True:
                os.write(self.end, b"\0" * _BLOCK)
        with suppress(BlockingIOError):
            while True:
                os.write(self.end, b"\0")
        os.set_blocking(self.end, True)

    def go_on(self) -> None:
        """Take lines again."""
        self._reads.set()

    def close(self) -> None:
        """Copy what is left; the agent must have ended."""
        self._reads.set()
        os.close(self.end)
        self._thread.join()
        os.close(self._reader)

    def _copy(self, log: Path) -> None:
        with log.open("ab") as file:
            while data := os.read(self._reader, _BLOCK):
                file.write(data.replace(b"\0", b""))
                file.flush()
                if not self._reads.is_set():
                    self._paused.set()
                    self._reads.wait()
                    self._paused.clear()
