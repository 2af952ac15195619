"""The numbers of a report as JSON: everything the page shows, in SI units."""

from __future__ import annotations

import math
from collections import Counter
from itertools import combinations
from typing import Any

import numpy as np

from robot_agent.patrol.actions import PATROLLING
from tools.metrics.idleness import idleness_figures
from tools.metrics.metrics import action_share, longest_avoid, spread
from tools.report.incidents import gate_times, override_times
from tools.report.run_log import RunLog
from tools.report.team import Team

ARRIVED_M = 0.10


def numbers(team: Team) -> dict[str, Any]:
    """Return the report's numbers; times are in s since the first recording's start."""
    border = team.folder.border
    return {
        "duration_s": team.end,
        "map": {
            "name": team.folder.name,
            "hash": team.runs[0].header.map_hash,
            "border_hash": team.runs[0].header.border_hash,
            "border_length_m": None if border is None else border.length,
        },
        "clocks": [
            {
                "robot": clock.robot,
                "correction_s": clock.correction,
                "how": clock.how,
                "residual_m": clock.residual,
            }
            for clock in team.clocks
        ],
        "robots": [_robot(team, run) for run in team.runs],
        "action_share": action_share(team.sampled),
        "longest_avoid_s": longest_avoid(team.sampled),
        "closest_m": _closest(team),
        "meetings": [
            {
                "t": meeting.t,
                "robots": list(meeting.robots),
                "actions": list(meeting.actions),
                "closest_m": meeting.closest_m,
                "outcome": meeting.outcome,
                "zone": team.words.zone(*team.middle(meeting)),
            }
            for meeting in team.meetings
        ],
        **idleness_figures(team.visits),
        "incidents": [
            {
                "robot": incident.robot,
                "start": incident.start,
                "end": incident.end,
                "what": incident.what,
                "reaction": incident.reaction,
                "stopped_after_s": incident.stopped_after,
                "moved_after_s": incident.moved_after,
                "zone": _zone(team, team.place(incident.robot, incident.start)),
            }
            for incident in team.incidents
        ],
    }


def _zone(team: Team, place: tuple[float, float] | None) -> str:
    """Return the name of the zone of a place, m, map frame; empty: of none, or None."""
    return "" if place is None else team.words.zone(*place)


def _robot(team: Team, run: RunLog) -> dict[str, Any]:
    """Return one recording's numbers."""
    sampled = next(s for s in team.sampled if s.name == run.name)
    bounds = run.bounds()
    bounds = bounds[np.isfinite(bounds)]
    header = run.header
    return {
        "robot": run.name,
        "recording": run.path.name,
        "seed": header.seed,
        "software": header.software_version,
        "versions": header.versions,
        "source": header.source,
        "start_s": run.shift,
        "end_s": run.end + run.shift,
        "truncated": run.truncated,
        "unreadable": run.unreadable,
        "ended_in_order": run.ended_in_order,
        "decisions": int(run.decision_t.size),
        "reach_s": reach_time(run),
        "border_distance_m": spread(_patrolling_distances(run)),
        "action_share": action_share([sampled]),
        "gate": {
            reason: {"times": count, "seconds": seconds}
            for reason, (count, seconds) in gate_times(run).items()
        },
        "overrides": {
            reason: {"times": count, "seconds": seconds}
            for reason, (count, seconds) in override_times(run).items()
        },
        "turns": dict(Counter(filter(None, run.turn))),
        "localization": {
            "health_share": _health_share(run),
            "bound_m": spread(bounds),
            "error_m": spread(run.reference_errors()[1]),
        },
        "battery_v": _battery(run),
        "lines": _lines(run),
        "process": process_numbers(run),
    }


def reach_time(run: RunLog) -> float | None:
    """Return the agent time of the first pose estimate within ARRIVED_M of the border, or None."""
    arrived = np.flatnonzero(run.distance <= ARRIVED_M)
    return float(run.decision_t[arrived[0]]) if arrived.size else None


def _patrolling_distances(run: RunLog) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return the distances from the border after arrival during patrol actions, (n,), m."""
    arrived = np.flatnonzero(run.distance <= ARRIVED_M)
    if not arrived.size:
        return np.empty(0)
    patrolling = np.isin(np.asarray(run.action), sorted(PATROLLING))
    patrolling[: arrived[0]] = False
    return run.distance[patrolling]


def _closest(team: Team) -> float | None:
    nearest = math.inf
    for a, b in combinations(team.sampled, 2):
        distance = np.hypot(*(a.position - b.position).T)
        if np.isfinite(distance).any():
            nearest = min(nearest, float(np.nanmin(distance)))
    return nearest if math.isfinite(nearest) else None


def _health_share(run: RunLog) -> dict[str, float]:
    """Return the share of statuses with each health, from the first localized one on."""
    stated = [status.localization.health for status in run.status]
    begun = next((i for i, health in enumerate(stated) if health == "localized"), len(stated))
    stated = stated[begun:]
    return {health: stated.count(health) / len(stated) for health in sorted(set(stated))}


def _battery(run: RunLog) -> dict[str, float | None]:
    volts = [status.battery for status in run.status if status.battery is not None]
    return {
        "first": volts[0] if volts else None,
        "last": volts[-1] if volts else None,
        "least": min(volts, default=None),
    }


def _lines(run: RunLog) -> dict[str, Any]:
    """Return each line's and session's counters from the last status; empty without one."""
    if not run.status:
        return {}
    last = run.status[-1]
    return {
        link: {
            "packets_good": device.packets_good,
            "packets_bad": device.packets_bad,
            "bytes_discarded": device.bytes_discarded,
            "bytes_received": device.bytes_received,
            "happened": device.happened,
        }
        for link, device in (("base", last.base), ("laser", last.laser))
    }


def process_numbers(run: RunLog) -> dict[str, float] | None:
    """Return load and lateness of the agent process; None without process reports (benches)."""
    if not run.process:
        return None
    cpu = np.array([report.cpu for report in run.process])
    late = np.array([report.lateness_max for report in run.process])
    return {
        "cpu_mean": float(cpu.mean()),
        "cpu_p95": float(np.percentile(cpu, 95)),
        "memory_mb": max(report.memory_mb for report in run.process),
        "lateness_median_s": float(np.median([r.lateness_median for r in run.process])),
        "lateness_p99_s": float(np.percentile(late, 99)),
        "lateness_max_s": float(late.max()),
        "longest_pause_s": max(report.longest_pause for report in run.process),
        "deadline_misses": sum(report.deadline_misses for report in run.process),
        "recorder_lost": run.process[-1].recorder_lost,
        "telemetry_dropped": run.process[-1].telemetry_dropped,
    }
