"""The figures of a bench as a table for people."""

from __future__ import annotations

from collections import Counter
from typing import Any


def bench_table(figures: dict[str, Any]) -> str:
    """Return the figures of ``bench --json`` as lines, a row per figure."""
    rows = [
        ("robots, seed, time", _run(figures)),
        ("contacts", str(figures["contacts"])),
        ("on the border after", _list(figures["reach_s"], "{:.0f} s", "never")),
        ("distance from border", _spread(figures["border_distance_m"])),
        ("meetings", _meetings(figures["meetings"])),
        ("closest approach", _number(figures["closest_m"], "{:.2f} m")),
        ("idleness", _idleness(figures)),
        ("settled idleness", _idleness(figures["settled"])),
        ("unpredictability", _bits(figures["unpredictability"])),
        ("intruder of 60 s seen", _intruders(figures)),
        ("time in actions", _shares(figures["action_share"])),
    ]
    rows += [(f"{each['robot']} stood", _stood(each)) for each in _standing(figures)]
    if "perception" in figures:
        rows.append(("teammates recognized", _share(figures["perception"]["recall"])))
    width = max(len(name) for name, _ in rows)
    return "\n".join(f"{name:<{width}}  {value}" for name, value in rows)


def _run(figures: dict[str, Any]) -> str:
    """Return what was run, and how fast."""
    speed = figures["duration_s"] / figures["wall_s"] if figures["wall_s"] else 0.0
    where = f", truth {figures['truth']}" if "truth" in figures else ""
    return (
        f"{figures['robots']}, {figures['seed']}, {figures['duration_s']:g} s in "
        f"{figures['wall_s']:.1f} s ({speed:.1f} x){where}"
    )


def _number(value: float | None, form: str, none: str = "-") -> str:
    return none if value is None else form.format(value)


def _list(values: list[float | None], form: str, none: str) -> str:
    return ", ".join(_number(value, form, none) for value in values)


def _spread(spread: dict[str, float | None]) -> str:
    return ", ".join(f"{name} {_number(value, '{:.3f} m')}" for name, value in spread.items())


def _meetings(meetings: list[dict[str, Any]]) -> str:
    outcomes = Counter(meeting["outcome"] for meeting in meetings)
    told = ", ".join(f"{count} {name}" for name, count in outcomes.most_common())
    return f"{len(meetings)}{': ' if told else ''}{told}"


def _idleness(figures: dict[str, Any]) -> str:
    idle = figures["idleness_s"]
    return ", ".join(
        f"{name} {_number(idle[name], '{:.1f} s')}"
        for name in ("average", "worst_average", "worst")
    )


def _bits(bits: dict[str, float | None]) -> str:
    per_place = _number(bits["per_place_bit"], "{:.2f} bit")
    return f"{per_place} a place, {_number(bits['conditional_bit'], '{:.2f} bit')} to a watcher"


def _intruders(figures: dict[str, Any]) -> str:
    seen, bound = figures["intruder_seen"], figures["intruder_bound"]["random"]["60"]
    if seen is None:
        return "-"
    told = ", ".join(f"{name} {_share(dwells['60'])}" for name, dwells in seen.items())
    return f"{told}; no patrol exceeds {_share(bound)} at random moments"


def _share(share: float | None) -> str:
    return _number(None if share is None else 100.0 * share, "{:.0f} %")


def _shares(shares: dict[str, float]) -> str:
    return ", ".join(f"{name} {_share(share)}" for name, share in shares.items() if share >= 0.005)


def _standing(figures: dict[str, Any]) -> list[dict[str, Any]]:
    return [each for each in figures.get("each", ()) if each["stood_s"] is not None]


def _stood(each: dict[str, Any]) -> str:
    return f"from {each['stood_s']:.0f} s: {each['said']}"
