"""A thread that is meant to run until it is closed: it cannot end unnoticed."""

from __future__ import annotations

import threading
from collections.abc import Callable


class LastingThread:
    """Runs a function on a thread of its own and keeps what ended it."""

    def __init__(self, target: Callable[[], None], name: str) -> None:
        self._target = target
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        try:
            self._target()
        except BaseException as error:  # noqa: BLE001 - whatever it is, the main thread raises it
            self._error = error

    def check(self) -> None:
        """Raise the exception that ended the thread, if one did."""
        if self._error is not None:
            raise RuntimeError(f"the {self._thread.name} has ended") from self._error

    def is_alive(self) -> bool:
        """Whether the function still runs."""
        return self._thread.is_alive()

    def join(self) -> None:
        """Wait for the function's end."""
        self._thread.join()
