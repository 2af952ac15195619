"""The payloads of several recordings in step, passed on to a team in order of time."""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence

from tools.monitor.recorded_payloads import RecordedPayload, RecordedPayloads
from tools.monitor.team_state import TeamState

_STATE_STREAMS = ("pose", "decision", "status")
_EACH = ("event", "intruder")
"""Streams of which no payload may be left out: they tell once."""


class PayloadStream:
    """A place in recordings, from which payloads are read on."""

    def __init__(self, files: Sequence[RecordedPayloads]) -> None:
        """Start at the first payload."""
        self._files = files
        self.start = min(file.start for file in files)
        self.end = max(file.end for file in files)
        self.restart(self.start)

    def restart(self, t: float) -> None:
        """Go to t, s since 1970."""
        self._rest = heapq.merge(
            *(file.payloads(t) for file in self._files), key=lambda payload: payload.t
        )
        self._next: RecordedPayload | None = next(self._rest, None)

    @property
    def next_t(self) -> float | None:
        """Time of the next payload, s since 1970; None after the last."""
        return None if self._next is None else self._next.t

    def feed(self, team: TeamState, t: float) -> None:
        """Pass the payloads up to t to a team."""
        for payload in self._up_to(t):
            team.receive(payload.key, payload.data, payload.t, payload.t)

    def feed_newest(self, team: TeamState, t: float, *, all_streams: bool = False) -> None:
        """Pass the payloads up to t to a team: of most streams the newest only.

        all_streams: also of those that alarms and histories do not need.
        """
        newest: dict[str, RecordedPayload] = {}
        for payload in self._up_to(t):
            stream = payload.key.rpartition("/")[2]
            if stream in _EACH:
                team.receive(payload.key, payload.data, payload.t, payload.t)
            elif all_streams or stream in _STATE_STREAMS:
                newest[payload.key] = payload
        for payload in newest.values():
            team.receive(payload.key, payload.data, payload.t, payload.t)

    def _up_to(self, t: float) -> Iterator[RecordedPayload]:
        while self._next is not None and self._next.t <= t:
            payload, self._next = self._next, next(self._rest, None)
            yield payload
