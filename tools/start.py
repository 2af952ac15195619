"""Entry of ``patrol``: Ctrl-C while its modules are still imported is as silent as later."""

from __future__ import annotations

import os
import signal
from types import FrameType

INTERRUPTED = 130


def main() -> int:
    """Run ``tools.cli``, which takes Ctrl-C over once it is there; return its exit status."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # not: started with nohup
        signal.signal(signal.SIGINT, _end)
    from tools.cli import main as run

    return run()


def _end(_number: int, _frame: FrameType | None) -> None:
    os._exit(INTERRUPTED)  # nothing is open yet; an exception here would be an import's error


if __name__ == "__main__":
    raise SystemExit(main())
