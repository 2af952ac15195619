"""Projection of many positions equals that of each."""

from pathlib import Path

import numpy as np
import pytest

from maps.map_folder import load_map_folder
from robot_agent.config import find_map
from tools.batch.border_feet import BorderFeet


@pytest.mark.parametrize("place", [("paper_lab", "border"), ("intel_lab", "open")])
def test_positions_project_as_one_by_one(place):
    border = load_map_folder(find_map(place[0], Path.cwd()), place[1]).border
    rng = np.random.default_rng(3)
    points = border.polyline(0.1)
    x, y = (points[rng.integers(0, len(points), 2000)] + rng.normal(0.0, 1.0, (2000, 2))).T
    near = rng.uniform(0.0, border.length, 2000)
    near[::3] = np.nan
    feet = BorderFeet(border)
    distance, s = feet.nearest(x, y, near)
    at = feet.at(s)
    for index in range(2000):
        hint = None if np.isnan(near[index]) else float(near[index])
        foot = border.project(float(x[index]), float(y[index]), hint)
        assert (distance[index], s[index]) == pytest.approx((foot.distance, foot.abscissa))
        expected = foot.x, foot.y, *foot.tangent, foot.curvature
        assert [float(each[index]) for each in at] == pytest.approx(expected, abs=1e-9)
