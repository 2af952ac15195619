"""The settled half of a run."""

import numpy as np

from maps.border import Border
from maps.border_primitives import Segment
from tools.metrics.settled import settled_figures

LINE = Border([Segment((0.0, 0.0), (10.0, 0.0))], closed=False)


def test_first_half_does_not_count():
    t = np.arange(0.0, 400.0, 0.1)
    # For 200 s it stands at the left end, then it drives to and fro within 40 s.
    phase = np.where(t < 200.0, 0.0, (t - 200.0) / 20.0 % 2.0)
    x = 10.0 * np.where(phase < 1.0, phase, 2.0 - phase)
    figures = settled_figures(LINE, [np.column_stack((x, np.zeros_like(x)))], t)
    assert figures["from_s"] == t[2000]
    assert 38.0 < figures["idleness_s"]["worst"] < 41.0
    assert figures["visits"]["cycles"] >= 5
