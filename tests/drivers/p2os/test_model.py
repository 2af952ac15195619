from __future__ import annotations

import math
import re

import pytest

from drivers.p2os.model import UnknownModelError, load_model, model_names

NAMES = [
    *("p2at", "p2at8", "p2at8+", "p2ce", "p2d8", "p2d8+", "p2de", "p2df", "p2dx"),
    *("p3at", "p3at-sh", "p3dx", "p3dx-sh"),
]


def test_all_models_load_by_their_subclass() -> None:
    assert model_names() == NAMES
    for name in model_names():
        model = load_model(name.upper())
        assert model.subclass == name
        assert len(model.sonar) == 16


@pytest.mark.parametrize(
    ("name", "distance_mm", "range_mm", "track_mm"),
    [
        ("p2dx", 0.84, 0.268, 357),
        ("p2de", 0.969, 0.268, 357),
        ("p2ce", 0.826, 0.268, 351),
        ("p2df", 0.485, 0.268, 333),
        ("p2d8", 0.485, 1, 357),
        ("p2d8+", 0.485, 1, 357),
        ("p3dx", 0.485, 1, 357),
        ("p3dx-sh", 1, 1, 357),
        ("p2at", 1.32, 0.268, 588),
        ("p2at8", 1.32, 1, 588),
        ("p2at8+", 0.465, 1, 588),
        ("p3at", 0.465, 1, 588),
        ("p3at-sh", 1, 1, 588),
    ],
)
def test_conversion_factors(
    name: str, distance_mm: float, range_mm: float, track_mm: float
) -> None:
    conversion = load_model(name).conversion
    assert conversion.distance == pytest.approx(distance_mm / 1000)
    assert conversion.range == pytest.approx(range_mm / 1000)
    assert 2000 / conversion.turn == pytest.approx(track_mm, abs=0.5)
    assert conversion.speed == 0.001
    assert conversion.wheel_speed == 0.02


@pytest.mark.parametrize(
    ("name", "x_mm", "y_mm"),
    [
        *[(name, 17, 8) for name in ("p2dx", "p2de", "p2df")],
        *[(name, 18, 0) for name in ("p2d8", "p2d8+", "p3dx")],
        *[(name, 160, 7) for name in ("p2at", "p2at8", "p2at8+")],
        *[("p2ce", 0, 0), ("p3dx-sh", 21, 0), ("p3at", 160, 0), ("p3at-sh", 125, 0)],
    ],
)
def test_laser_mounts(name: str, x_mm: float, y_mm: float) -> None:
    assert load_model(name).laser_mount == (x_mm / 1000, y_mm / 1000, 0.0)


@pytest.mark.parametrize("name", NAMES)
def test_sonar_is_symmetric_left_to_right(name: str) -> None:
    sonar = load_model(name).sonar
    for first, mirrored in [(i, 7 - i) for i in range(4)] + [(8 + i, 15 - i) for i in range(4)]:
        left, right = sonar[first], sonar[mirrored]
        assert (left.x, left.y, left.heading_deg) == (right.x, -right.y, -right.heading_deg)
    assert all(mount.x > 0 for mount in sonar[:8])
    assert all(mount.x < 0 for mount in sonar[8:])


def test_geometry_of_the_2dx() -> None:
    model = load_model("p2dx")
    assert model.laser_mount == (0.017, 0.008, 0.0)
    assert model.body.front + model.body.rear == pytest.approx(0.511)
    assert model.body.width == 0.425
    assert model.top_turn_rate == pytest.approx(math.radians(500))


def test_unknown_model_names_the_known_ones() -> None:
    with pytest.raises(UnknownModelError, match=re.escape(", ".join(NAMES))) as failure:
        load_model("seekur")
    assert "'seekur'" in str(failure.value)
