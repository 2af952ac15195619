"""Made-up results of a study's runs."""

from __future__ import annotations

from typing import Any

from tools.studies.study import Case, Result, Run


def result_of(case: Case, seed: int, worst: float | None) -> Result:
    """Return a result; worst: its idleness, s, None for a run that has none."""
    idleness = {"idleness_s": {"average": worst, "worst": worst}}
    bits = {"unpredictability": {"per_place_bit": None, "conditional_bit": None}}
    figures: dict[str, Any] = {
        **idleness,
        **bits,
        "settled": {**idleness, **bits, "border_distance_m": {"p99": None}},
        "interferences": 0,
        "meetings": [],
        "reach_s": [0.0],
        "border_distance_m": {"p99": None, "max": None},
        "closest_m": None,
        "longest_avoid_s": 0.0,
        "gate_stops": 0,
        "contacts": 0,
    }
    return Result(Run(case, seed, "x", "border", 1.0), figures)
