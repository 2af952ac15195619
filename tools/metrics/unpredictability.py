"""How far a patrol's return times can be foretold by who watches a place.

Both figures are entropies, in bits, of the interval to the next visit in bins of 10 s. The return
time entropy of a place (Duan, George and Bullo, "Markov chains with maximum return time entropy for
robotic surveillance", 2020) is 0 for a periodic patrol. Pooling the places would call a robot
random that shuttles like clockwork: its intervals differ from place to place. The conditional one
is what is left to guess for somebody who knows the place's last two intervals, and which way the
last robot left.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from tools.metrics.border_visits import BorderVisits
from tools.metrics.idleness import intervals_of

BIN_S = 10.0
"""Width of the bins, s."""
STRETCHES = 10
"""Stretches of an open border whose places are alike enough to be counted together; ours."""
_KNOWN = 2  # intervals before the present one that the watcher knows


def unpredictability_figures(visits: BorderVisits | None) -> dict[str, Any]:
    """Return ``unpredictability`` of ``bench --json``; None where there are too few visits.

    per_place_bit: mean over the places of the entropy of their intervals. conditional_bit: entropy
    of an interval by the two before it and the way that the last robot left, over all places of a
    closed border, or of each tenth of an open one. Both are too low in short runs: in an hour of
    three robots a place has 75 intervals.
    """
    if visits is None:
        return {"unpredictability": {"per_place_bit": None, "conditional_bit": None}}
    passing = visits.passing
    rows = [
        (stretch, place.ways, np.floor(intervals_of(place, passing) / BIN_S).astype(int))
        for stretch, place in zip(stretches(visits), visits.places, strict=True)
    ]
    of_places = [entropy(Counter(bins.tolist()).values()) for _, _, bins in rows if bins.size]
    after: defaultdict[tuple[int, ...], Counter[int]] = defaultdict(Counter)
    for stretch, ways, bins in rows:
        for known, interval in _with_known(ways.tolist(), bins.tolist()):
            after[(stretch, *known)][interval] += 1
    total = sum(map(Counter.total, after.values()))
    conditional = sum(entropy(each.values()) * each.total() for each in after.values())
    return {
        "unpredictability": {
            "per_place_bit": float(np.mean(of_places)) if of_places else None,
            "conditional_bit": conditional / total if total else None,
        }
    }


def stretches(visits: BorderVisits) -> list[int]:
    """Return the stretch of each place: all one on a closed border, tenths of an open one."""
    if visits.closed or not visits.places:
        return [0] * len(visits.places)
    along = visits.abscissae / (float(visits.abscissae.max()) + 1e-9)
    return [int(share * STRETCHES) for share in along.tolist()]


def entropy(counts: Iterable[int]) -> float:
    """Return the entropy, bit, of outcomes that were counted so often."""
    share = np.array(list(counts), dtype=float)
    share /= share.sum()
    return abs(float(-(share * np.log2(share)).sum()))


def _with_known(ways: list[int], bins: list[int]) -> Iterator[tuple[tuple[int, ...], int]]:
    """Yield each interval with what was known at its begin: way, last interval, the one before."""
    for number in range(_KNOWN, len(bins)):
        yield (ways[number], *bins[number - _KNOWN : number]), bins[number]
