"""Finds the incidents of a run, their times, and the robot's reaction."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from robot_agent.motion.gate_hold import STOPPING
from robot_agent.motion.gate_words import GATE_WORDS
from tools.report.run_log import Floats, RunLog

SILENT_S = {"base": 0.35, "laser": 0.6}
"""Time without bytes after which a link is silent: about three of its messages are missing."""
FROZEN_S = 0.3
NOISE_PAUSE_S = 3.0
UNSURE_S = 2.0
"""Shorter periods of unsure localization are ignored."""
JUMP_M = 0.25
MERGE_S = 1.0
STOP_WATCH_S = 1.0
"""Time after the start of a short incident within which a stop command counts as its reaction."""
END_MARGIN_S = 0.05
GOOD_STATES = {"base": "ready", "laser": "streaming"}


_BROKEN_OFF = "recording breaks off"
_NO_COMMANDS = frozenset(("agent frozen", "base port lost"))
"""Incidents during which the agent cannot send commands to the base."""


@dataclass(frozen=True, slots=True)
class Span:
    """An incident or state from ``start`` to ``end``, agent time, s."""

    start: float
    end: float
    what: str

    def overlaps(self, other: Span) -> bool:
        """Return whether two spans overlap or are less than MERGE_S apart."""
        return self.start < other.end + MERGE_S and other.start < self.end + MERGE_S


@dataclass(frozen=True, slots=True)
class Incident:
    """One incident of one robot; times are team times, s."""

    robot: str
    start: float
    end: float
    what: str
    reaction: str
    stopped_after: float | None = None
    """Time from the start to the stop command, s; 0 if it stood; None without a stop command."""
    moved_after: float | None = None
    """Time from the end to the next motion command, s; None without one."""

    @property
    def is_end(self) -> bool:
        """Whether the incident is the truncation of the recording."""
        return self.what.startswith(_BROKEN_OFF)


def incidents(run: RunLog) -> list[Incident]:
    """Return a run's incidents in order of time."""
    seen = merged(_freezes(run))
    for link in GOOD_STATES:
        # Causes first: a lost port is silent too, and its session is lost.
        known = list(seen)
        for find in (_lost_ports, _silences, _lost_sessions):
            fresh = [span for span in merged(find(run, link)) if not any(map(span.overlaps, known))]
            known += fresh
            seen += fresh
    others = (_noise, _lost_poses, _held, _recorder, _operator, _death)
    spans = seen + merged(span for look in others for span in look(run))
    # A pose jump at the end of another incident belongs to that.
    spans += [jump for jump in merged(_jumps(run)) if not any(map(jump.overlaps, seen))]
    return [_with_reaction(run, span) for span in sorted(spans, key=lambda span: span.start)]


def merged(spans: Iterable[Span]) -> list[Span]:
    """Join spans of one kind that are less than MERGE_S apart."""
    result: list[Span] = []
    for span in sorted(spans, key=lambda span: (span.what, span.start)):
        last = result[-1] if result else None
        if last is not None and last.what == span.what and span.start - last.end < MERGE_S:
            result[-1] = Span(last.start, max(last.end, span.end), span.what)
        else:
            result.append(span)
    return result


def gate_holds(run: RunLog) -> list[Span]:
    """Return the spans in which the gate held the robot, with the reason."""
    held = [reason if reason in STOPPING else "" for reason in run.gate]
    return merged(_stretches(run, held))


def gate_times(run: RunLog) -> dict[str, tuple[int, float]]:
    """Return count and total duration, s, of each reason of the gate."""
    return _totals(merged(_stretches(run, run.gate)))


def override_times(run: RunLog) -> dict[str, tuple[int, float]]:
    """Return count and total duration, s, of each override."""
    return _totals(_stretches(run, run.override))


def _totals(spans: Iterable[Span]) -> dict[str, tuple[int, float]]:
    """Return count and total duration, s, of the spans by what they are of."""
    result: dict[str, tuple[int, float]] = {}
    for span in spans:
        count, seconds = result.get(span.what, (0, 0.0))
        result[span.what] = (count + 1, seconds + span.end - span.start)
    return result


def _stretches(run: RunLog, words: Sequence[str]) -> Iterator[Span]:
    """Yield a span for each run of decisions with the same word; words: one per decision.

    Empty words are skipped; a pause of MERGE_S between decisions ends a span.
    """
    start = 0
    for index in range(1, len(words) + 1):
        whole = index < len(words) and words[index] == words[start]
        if whole and run.decision_t[index] - run.decision_t[index - 1] < MERGE_S:
            continue
        if words[start]:
            end = run.decision_t[min(index, len(words) - 1)]
            last = min(float(end), _last(run, index))
            yield Span(float(run.decision_t[start]), last, words[start])
        start = index


def _last(run: RunLog, index: int) -> float:
    """Return the end of the decision before ``index``: one control step later."""
    return float(run.decision_t[index - 1]) + 0.1


def _lost_ports(run: RunLog, link: str) -> Iterator[Span]:
    changes = [change for change in run.links if change.link == link]
    lost_at, was_up = math.nan, False
    for change in changes:
        if change.up and not math.isnan(lost_at):
            yield Span(lost_at, change.t, f"{link} port lost")
            lost_at = math.nan
        elif not change.up and was_up:
            lost_at = change.t
        was_up = change.up
    if not math.isnan(lost_at):
        yield Span(lost_at, run.end, f"{link} port lost")


def _silences(run: RunLog, link: str) -> Iterator[Span]:
    """Yield the silences of a link once in service; none for a log, whose scans are sparse."""
    settled = _in_service(run, link)
    if run.is_log or settled is None:
        return
    times = run.received[link]
    times = times[times >= settled]
    if not run.ended_in_order:
        times = np.append(times, run.end)
    for index in np.flatnonzero(np.diff(times) > SILENT_S[link]):
        yield Span(float(times[index]), float(times[index + 1]), f"{link} silent")


def _in_service(run: RunLog, link: str) -> float | None:
    """Return the time of the first status with a link's session in service; None if never."""
    good = (
        t
        for t, status in zip(run.status_t, run.status, strict=True)
        if getattr(status, link).state == GOOD_STATES[link]
    )
    return next(good, None)


def _lost_sessions(run: RunLog, link: str) -> Iterator[Span]:
    was_good, lost_at, state = False, math.nan, ""
    for t, status in zip(run.status_t.tolist(), run.status, strict=True):
        now = getattr(status, link).state
        if now != GOOD_STATES[link] and was_good:
            lost_at, state = t, now
        elif now == GOOD_STATES[link] and not math.isnan(lost_at):
            yield Span(lost_at, t, f"{link} session lost ({state})")
            lost_at = math.nan
        was_good = now == GOOD_STATES[link]
    if not math.isnan(lost_at) and not run.ended_in_order:
        yield Span(lost_at, run.end, f"{link} session lost ({state})")


def _noise(run: RunLog) -> Iterator[Span]:
    """Yield spans with damaged packets while the session was in service."""
    for link, good in GOOD_STATES.items():
        bad = np.array([getattr(status, link).packets_bad for status in run.status])
        well = np.array([getattr(status, link).state == good for status in run.status])
        if bad.size < 2:
            continue
        fresh = np.flatnonzero((np.diff(bad) > 0) & well[:-1])
        if not fresh.size:
            continue
        breaks = np.flatnonzero(np.diff(run.status_t[fresh]) > NOISE_PAUSE_S) + 1
        for group in np.split(fresh, breaks):
            count = int(bad[group[-1] + 1] - bad[group[0]])
            if count > 1:
                start, end = run.status_t[group[0]], run.status_t[group[-1] + 1]
                yield Span(float(start), float(end), f"{link} line noise: {count} bad packets")


def _freezes(run: RunLog) -> Iterator[Span]:
    for index in np.flatnonzero(np.diff(run.tick_t) > FROZEN_S):
        yield Span(float(run.tick_t[index]), float(run.tick_t[index + 1]), "agent frozen")


def _lost_poses(run: RunLog) -> Iterator[Span]:
    changes = [line for line in run.lines if line.part == "localization"]
    sure = next((line.t for line in changes if line.message == "localized"), math.inf)
    ends = [*(line.t for line in changes), run.end][1:]
    for line, until in zip(changes, ends, strict=True):
        if line.t < sure or line.message == "localized":
            continue
        if line.message == "lost" or until - line.t > UNSURE_S:
            yield Span(line.t, until, f"localization {line.message}")


def _jumps(run: RunLog) -> Iterator[Span]:
    """Yield pose changes between decisions by more than the robot can have driven."""
    if run.is_log or run.decision_t.size < 2:
        return
    steps = np.hypot(*np.diff(run.pose[:, :2], axis=0).T)
    for index in np.flatnonzero((steps > JUMP_M) & (np.diff(run.decision_t) < MERGE_S)):
        t = float(run.decision_t[index + 1])
        yield Span(t, t, f"pose jumped by {steps[index]:.2f} m: carried, or found again")


_OWN_INCIDENT = frozenset(("stale_base", "stale_laser", "not_localized"))
"""Reasons of the gate that follow from incidents reported themselves."""


def _held(run: RunLog) -> Iterator[Span]:
    for span in gate_holds(run):
        if span.what not in _OWN_INCIDENT and span.end - span.start > MERGE_S:
            yield Span(
                span.start, span.end, f"held by the gate: {GATE_WORDS.get(span.what, span.what)}"
            )


def _recorder(run: RunLog) -> Iterator[Span]:
    for t, lost in run.gaps:
        yield Span(t, t, f"recorder lost {lost} records")
    for line in run.lines:
        if line.part == "recorder":
            yield Span(line.t, line.t, line.message)


def _operator(run: RunLog) -> Iterator[Span]:
    """Yield the spans in which the operator was disconnected, after the first connection."""
    seen, gone = False, math.nan
    for t, report in zip(run.process_t.tolist(), run.process, strict=True):
        if report.operator is False and seen and math.isnan(gone):
            gone = t
        elif report.operator and not math.isnan(gone):
            yield Span(gone, t, "operator away")
            gone = math.nan
        seen = seen or bool(report.operator)
    if not math.isnan(gone):
        yield Span(gone, run.end, "operator away")


def _death(run: RunLog) -> Iterator[Span]:
    if not run.ended_in_order and run.truncated:
        yield Span(run.end, run.end, f"{_BROKEN_OFF}: agent killed or power cut")


def absences(earlier: RunLog, later: RunLog) -> Incident:
    """Return the incident of the time without an agent between two runs of one robot."""
    start, end = earlier.end + earlier.shift, later.shift
    how = "shut down" if earlier.ended_in_order else "killed, or power cut"
    moved = _first(later.order_t[later.moving_order], 0.0)
    again = "" if moved is None else f", moved {moved:.2f} s after the new start"
    stands = "stopped the robot first" if earlier.ended_in_order else "base's own watchdog stops it"
    return Incident(
        earlier.name, start, end, f"no agent ({how})", f"{stands}{again}", moved_after=moved
    )


def _with_reaction(run: RunLog, span: Span) -> Incident:
    stopped = _stopped_after(run, span)
    moved = None
    if stopped is not None or not _drives(run, span):
        moved = _first(run.order_t[run.moving_order], max(span.end, span.start + (stopped or 0.0)))
        moved = None if moved is None else moved - span.end
    return Incident(
        run.name,
        span.start + run.shift,
        span.end + run.shift,
        span.what,
        _reaction_text(run, span, stopped, moved),
        stopped,
        moved,
    )


def _stopped_after(run: RunLog, span: Span) -> float | None:
    """Return the time from a span's start to the stop command, s; 0 if the base stood already.

    None without a stop command: a frozen agent, or one without a port, sends none.
    """
    before = np.searchsorted(run.order_t, span.start, side="right") - 1
    if before < 0 or not run.moving_order[before]:
        return 0.0
    stop = _first(run.order_t[~run.moving_order], span.start)
    latest = max(span.end, span.start + STOP_WATCH_S)
    if span.what in _NO_COMMANDS:
        latest = span.end - END_MARGIN_S
    if run.shutdown_at is not None:
        latest = min(latest, run.shutdown_at - END_MARGIN_S)
    return None if stop is None or stop > latest else stop - span.start


def _first(times: Floats, after: float) -> float | None:
    index = np.searchsorted(times, after)
    return float(times[index]) if index < times.size else None


def _reaction_text(run: RunLog, span: Span, stopped: float | None, moved: float | None) -> str:
    if stopped is None and _drives(run, span):
        return "patrolled on"
    if stopped is None:
        first = "no command possible: the base's own watchdog stops it"
    else:
        first = "was standing" if stopped == 0.0 else f"stop command after {stopped:.2f} s"
    if moved is None:
        return f"{first}, did not move again"
    return f"{first}, moved {max(moved, 0.0):.2f} s after its end"


def _drives(run: RunLog, span: Span) -> bool:
    """Return whether decisions were made during a span, or within 1 s of its start."""
    if span.what in _NO_COMMANDS or span.what.startswith(_BROKEN_OFF):
        return False
    inside = (run.decision_t >= span.start) & (run.decision_t <= max(span.end, span.start + 1.0))
    return bool(inside.any())
