"""The clock jumps while robot and monitor are linked by TLS: out of the certificates, and back."""

from __future__ import annotations

import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import closing
from itertools import cycle, islice
from pathlib import Path

import msgspec

from tools.campaign.clock_party import ROBOT, TEAM, Seen
from tools.campaign.endurance import EnduranceError
from tools.campaign.footprint import Footprint
from tools.campaign.set_clock import SetClock, faketime_library
from tools.deploy.certificates import make_keys
from tools.deploy.child_program import environment, program
from tools.monitor.endpoint import free_endpoint

EXPIRED, EARLIER, RIGHT = "+20y", "-30y", "+0"
"""Certificates of `patrol keys` are valid for ten years, and from 1970 on."""
_PATIENCE_S = 10.0
"""Time within which the link is made again, and no trouble told, once the clock is right."""
_LOOK_S = 0.2


def jump_clocks(cycles: int) -> Iterator[Footprint]:
    """Let the clock jump and come back; the process holds monitor and robot.

    Raises EnduranceError if a link is lost, is made with certificates that have expired, is not
    made again when the clock is right, or what is wrong is not said.
    """
    library = faketime_library()
    if library is None:
        raise EnduranceError("libfaketime is not there: `apt-get install faketime`")
    with tempfile.TemporaryDirectory() as folder:
        clock = SetClock(library, Path(folder, "clock"))
        with closing(_Party(Path(folder), clock)) as party:
            party.recover()
            for jump in islice(cycle((EXPIRED, EARLIER)), cycles):
                clock.set(jump)
                _require_link_kept(party.ask("look"), jump)
                _require_new_link(party.ask("again"), jump)
                clock.set(RIGHT)
                yield party.recover().footprint


class _Party:
    """The process that holds monitor and robot."""

    def __init__(self, folder: Path, clock: SetClock) -> None:
        make_keys(folder, TEAM, [ROBOT], ["127.0.0.1"])
        endpoint = free_endpoint().replace("tcp/", "tls/")
        self._process = subprocess.Popen(
            program("tools.campaign.clock_party", str(folder), endpoint),
            env={**environment(), **clock.environment},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def ask(self, order: str) -> Seen:
        """Give an order; return what is so then."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(f"{order}\n")
        self._process.stdin.flush()
        line = self._process.stdout.readline()
        if not line:
            raise EnduranceError("the process of monitor and robot has ended")
        return msgspec.json.decode(line, type=Seen)

    def recover(self) -> Seen:
        """Return what is so once robot and monitor are linked and nothing is wrong."""
        give_up = time.monotonic() + _PATIENCE_S
        while time.monotonic() < give_up:
            seen = self.ask("look")
            if seen.heard and not seen.failed and not seen.told:
                return seen
            time.sleep(_LOOK_S)
        raise EnduranceError(f"no link although the clock is right: {seen}")

    def close(self) -> None:
        """End the process."""
        self._process.communicate()


def _require_link_kept(seen: Seen, jump: str) -> None:
    """Raise EnduranceError if a link that was there is lost, or the monitor says not what is so."""
    if not seen.heard:
        raise EnduranceError(f"{jump}: the link was lost: {seen}")
    if _tells_expiry(seen.told) != (jump == EXPIRED):
        raise EnduranceError(f"{jump}: the monitor tells {seen.told}")


def _require_new_link(seen: Seen, jump: str) -> None:
    """Raise EnduranceError if a new link is made with expired certificates, or refused without."""
    if seen.heard != (jump != EXPIRED):
        raise EnduranceError(f"{jump}: a new link was {'made' if seen.heard else 'refused'}")
    if _tells_expiry([seen.failed]) != (jump == EXPIRED):
        raise EnduranceError(f"{jump}: the robot tells {seen.failed!r}")


def _tells_expiry(words: list[str]) -> bool:
    return any("valid until" in each and "set the clock" in each for each in words)
