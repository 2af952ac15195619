"""Silhouettes: named ones, polygons of a configuration, and their widths."""

from __future__ import annotations

import math

import numpy as np
import pytest

from robot_agent.config import ConfigError, parse_config
from robot_agent.perception.silhouette import (
    BODY,
    CUT_CORNERS,
    HOUSING,
    Silhouette,
    SilhouetteError,
    Silhouettes,
    named,
    rectangle,
)

PIONEER = rectangle(0.511, 0.425)


def test_a_rectangle_is_as_wide_as_its_sides_and_its_diagonal() -> None:
    shape = Silhouette.of(PIONEER)
    assert shape.widths.min() == pytest.approx(0.425)
    assert shape.widths.max() == pytest.approx(math.hypot(0.511, 0.425), abs=0.01)
    assert shape.depths[0] == pytest.approx(0.2125), "seen end-on across, it is half as deep"


def test_headings_cover_only_what_looks_different() -> None:
    assert np.ptp(Silhouette.of(PIONEER).headings) < math.pi
    assert np.ptp(Silhouette.of(named(HOUSING, PIONEER)).headings) < math.pi / 2
    wedge = ((0.3, 0.0), (-0.2, 0.2), (-0.2, -0.2))
    assert np.ptp(Silhouette.of(wedge).headings) > math.pi


def test_cut_corners_keep_length_and_width() -> None:
    cut = np.array(named(CUT_CORNERS, PIONEER))
    assert len(cut) == 8
    assert np.ptp(cut, axis=0) == pytest.approx((0.511, 0.425))
    Silhouette.of(named(CUT_CORNERS, PIONEER))  # convex, counter-clockwise


def test_a_polygon_is_about_the_middle_of_its_box() -> None:
    shifted = tuple((x + 3.0, y - 1.0) for x, y in PIONEER)
    assert np.allclose(Silhouette.of(shifted).corners, PIONEER)


@pytest.mark.parametrize(
    ("corners", "reason"),
    [
        (((0.0, 0.0), (1.0, 0.0)), "three corners"),
        (tuple(reversed(PIONEER)), "counter-clockwise"),
        (((0.2, 0.2), (0.0, 0.05), (-0.2, 0.2), (-0.2, -0.2), (0.2, -0.2)), "not convex"),
        (rectangle(511.0, 425.0), "in m"),
    ],
)
def test_unusable_polygons_are_refused(
    corners: tuple[tuple[float, float], ...], reason: str
) -> None:
    with pytest.raises(SilhouetteError, match=reason):
        Silhouette.of(corners)


def test_a_segment_admits_the_silhouettes_of_its_width() -> None:
    all_three = Silhouettes.admitted((BODY, CUT_CORNERS, HOUSING), PIONEER)
    assert all_three.admitting(0.18).tolist() == [False, False, True]
    assert all_three.admitting(0.5).tolist() == [True, True, False]
    assert all_three.admitting(0.7).tolist() == [True, False, False]
    assert not all_three.admitting(1.0).any()


def test_the_configuration_takes_names_and_corners() -> None:
    text = (
        b'perception.silhouettes = ["body", [[0.3, -0.2], [0.3, 0.2], [-0.3, 0.2], [-0.3, -0.2]]]'
    )
    settings = parse_config(text, "robot.toml").perception
    assert len(Silhouettes.admitted(settings.silhouettes, PIONEER).shapes) == 2


@pytest.mark.parametrize("value", ['["bodi"]', "[]", "[[[0.1, 0.1], [0.2, 0.2]]]", "[7]"])
def test_unusable_silhouettes_are_refused_with_the_key(value: str) -> None:
    with pytest.raises(ConfigError, match=r"robot\.toml: perception"):
        parse_config(f"perception.silhouettes = {value}".encode(), "robot.toml")
