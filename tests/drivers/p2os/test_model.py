from __future__ import annotations

import math

import pytest

from drivers.p2os.model import UnknownModelError, load_model, model_names


def test_all_models_load_by_their_subclass() -> None:
    assert model_names() == ["p2at", "p2de", "p2dx", "p3dx"]
    for name in model_names():
        model = load_model(name.upper())
        assert model.subclass == name
        assert len(model.sonar) == 16


@pytest.mark.parametrize(
    ("name", "distance_mm", "range_mm", "track_mm"),
    [
        ("p2dx", 0.84, 0.268, 357),
        ("p2de", 0.969, 0.268, 357),
        ("p3dx", 0.485, 1, 357),
        ("p2at", 1.32, 0.268, 588),
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


@pytest.mark.parametrize("name", ["p2at", "p2de", "p2dx", "p3dx"])
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
    assert (model.body.width, model.body.swing_radius) == (0.425, 0.25)
    assert model.top_turn_rate == pytest.approx(math.radians(500))


def test_unknown_model_names_the_known_ones() -> None:
    with pytest.raises(UnknownModelError, match=r"'seekur'.*p2at, p2de, p2dx, p3dx"):
        load_model("seekur")
