"""The table of a study: one row a case, each figure with its 95 % confidence interval."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from maps.whole_file import whole_file
from tools.logs.csv_cells import csv_cells
from tools.metrics.intruder_exposure import DWELL_S
from tools.studies.study import Case, Result

CONFIDENCE = 0.95

Extract = Callable[[dict[str, Any]], float | None]


def _after_wrecks(figures: dict[str, Any], name: str) -> float | None:
    """Return a figure of the border after robots died on it; None if none did."""
    value: float | None = (figures.get("after_wrecks") or {}).get(name)
    return value


def _intruder(figures: dict[str, Any], kind: str, dwell: str) -> float | None:
    """Return the probability of seeing an intruder of a kind that dwells so long, s."""
    seen = figures.get("intruder_seen")
    value: float | None = ((seen or {}).get(kind) or {}).get(dwell)
    return value


def _settled_intruder(kind: str, dwell: str) -> Extract:
    return lambda figures: _intruder(figures["settled"], kind, dwell)


def _bits(figures: dict[str, Any], kind: str) -> float | None:
    value: float | None = figures["unpredictability"][kind]
    return value


def _meetings_ended(figures: dict[str, Any]) -> float | None:
    """Return the share of the meetings that ended as the paper tells: turned back or avoided.

    Those that the end of the run cuts off do not count; None without others.
    """
    outcomes = [meeting["outcome"] for meeting in figures["meetings"]]
    ended = [outcome for outcome in outcomes if outcome != "cut off"]
    well = sum(outcome in {"turned back", "avoided"} for outcome in ended)
    return well / len(ended) if ended else None


def _arrived(figures: dict[str, Any]) -> float:
    """Return the share of the robots that came to the border."""
    reached: list[float | None] = figures["reach_s"]
    return sum(each is not None for each in reached) / len(reached)


COLUMNS: dict[str, Extract] = {
    "idleness_average_s": lambda figures: figures["idleness_s"]["average"],
    "idleness_worst_s": lambda figures: figures["idleness_s"]["worst"],
    "per_place_bit": lambda figures: _bits(figures, "per_place_bit"),
    "conditional_bit": lambda figures: _bits(figures, "conditional_bit"),
    "settled_idleness_average_s": lambda figures: figures["settled"]["idleness_s"]["average"],
    "settled_idleness_worst_s": lambda figures: figures["settled"]["idleness_s"]["worst"],
    "settled_per_place_bit": lambda figures: _bits(figures["settled"], "per_place_bit"),
    "settled_conditional_bit": lambda figures: _bits(figures["settled"], "conditional_bit"),
    "interferences": lambda figures: figures["interferences"],
    "meetings": lambda figures: len(figures["meetings"]),
    "meetings_ended": _meetings_ended,
    "arrived": _arrived,
    "border_distance_p99_m": lambda figures: figures["border_distance_m"]["p99"],
    "settled_border_distance_p99_m": lambda figures: figures["settled"]["border_distance_m"]["p99"],
    "border_distance_max_m": lambda figures: figures["border_distance_m"]["max"],
    "closest_m": lambda figures: figures["closest_m"],
    "longest_avoid_s": lambda figures: figures["longest_avoid_s"],
    "gate_stops": lambda figures: figures["gate_stops"],
    "contacts": lambda figures: figures["contacts"],
    "driven_again_laps": lambda figures: _after_wrecks(figures, "laps"),
    "undriven_m": lambda figures: _after_wrecks(figures, "undriven_m"),
    "abandoned_m": lambda figures: _after_wrecks(figures, "abandoned_m"),
    "crowded_m": lambda figures: _after_wrecks(figures, "crowded_m"),
    "settled_idleness_instantaneous_s": lambda figures: figures["settled"]["idleness_s"].get(
        "instantaneous"
    ),
    **{
        f"settled_{kind}_{dwell:g}s": _settled_intruder(kind, f"{dwell:g}")
        for kind in ("random", "watcher", "all_knowing")
        for dwell in DWELL_S
    },
}


@dataclass(frozen=True)
class Summary:
    """Statistics of one figure over the runs of a case."""

    mean: float
    half_width: float
    """Half width of the mean's confidence interval; nan for a single run."""
    worst: float
    runs: int

    def __str__(self) -> str:
        if math.isnan(self.half_width):
            return f"{self.mean:.3g}"
        return f"{self.mean:.3g} ± {self.half_width:.2g}"


def summarize(values: NDArray[np.float64]) -> Summary | None:
    """Return mean and Student's interval of values (n,); None for n = 0."""
    n = len(values)
    if n == 0:
        return None
    spread = float(values.std(ddof=1)) if n > 1 else math.nan
    quantile = float(student.ppf((1 + CONFIDENCE) / 2, n - 1)) if n > 1 else math.nan
    return Summary(float(values.mean()), quantile * spread / math.sqrt(n), float(values.max()), n)


def table(results: Sequence[Result]) -> dict[Case, dict[str, Summary | None]]:
    """Return every column's summary by case, cases in order of first appearance."""
    by_case: dict[Case, list[dict[str, Any]]] = {}
    for result in results:
        by_case.setdefault(result.run.case, []).append(result.figures)
    return {
        case: {name: _column(extract, runs) for name, extract in COLUMNS.items()}
        for case, runs in by_case.items()
    }


def _column(extract: Extract, runs: Sequence[dict[str, Any]]) -> Summary | None:
    values = [value for figures in runs if (value := extract(figures)) is not None]
    return summarize(np.array(values, dtype=np.float64))


def write_csv(results: Sequence[Result], path: Path) -> None:
    """Write one line per run: varied settings, seed, every column. results: at least one."""
    varied = [key for key, _ in results[0].run.case.values]
    with whole_file(path) as part, part.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(csv_cells([*varied, "seed", *COLUMNS]))
        for result in results:
            values = [value for _, value in result.run.case.values]
            figures = [extract(result.figures) for extract in COLUMNS.values()]
            writer.writerow(csv_cells([*values, result.run.seed, *figures]))
