from __future__ import annotations

import math
import re

import pytest

from drivers.p2os.model import UnknownModelError, load_model, model_names

TWO_DX = ("p2ce", "p2d8", "p2d8+", "p2de", "p2df", "p2dx", "p3dx", "p3dx-sh")
FOUR_AT = ("p2at", "p2at8", "p2at8+", "p3at", "p3at-sh")
NAMES = model_names()


def test_all_robots_of_the_vendors_parameter_files_have_a_model() -> None:
    assert len(NAMES) == 48
    assert {*TWO_DX, *FOUR_AT} < set(NAMES)
    for name in NAMES:
        assert load_model(name.upper()).subclass.lower() == name


@pytest.mark.parametrize("name", NAMES)
def test_model_is_consistent(name: str) -> None:
    model = load_model(name)
    body, laser = model.body, model.laser
    assert 0.3 < body.front + body.rear < 1.5
    assert 0.25 < body.width < 1.3
    for x, y in [(laser.x, laser.y), *[(mount.x, mount.y) for mount in model.sonar]]:
        assert -body.rear <= x <= body.front
        assert abs(y) <= 0.5 * body.width + 1e-9
    for mount in model.sonar:
        assert abs(mount.heading_deg) <= 180.0
        if (mount.x, mount.y) != (0.0, 0.0):  # a number without a transducer
            outwards = mount.x * math.cos(mount.heading) + mount.y * math.sin(mount.heading)
            assert outwards > 0.0
    assert all(0 <= count <= 7 for count in model.bumper_segments)
    assert 0.15 < 2.0 / model.conversion.turn < 0.7  # track of the wheels
    first_pioneer = name in ("pion1m", "pion1x", "pionat", "psos1m", "psos1x", "psos43m")
    assert model.conversion.heading_counts == (1024 if first_pioneer else 4096)


@pytest.mark.parametrize(
    ("name", "count"),
    [
        *[(name, 16) for name in (*TWO_DX, *FOUR_AT, "patrolbot-sh", "powerbot-sh-uarcs")],
        *[("amigo", 8), ("p2pb", 24), ("p2pp", 24), ("pion1m", 7), ("pioneer-lx", 4)],
        *[(name, 32) for name in ("peoplebot-sh", "perfpb", "powerbot", "powerbot-sh")],
        *[(name, 0) for name in ("seekur", "seekurjr", "wheelchair-sh")],
    ],
)
def test_number_of_sonars(name: str, count: int) -> None:
    assert len(load_model(name).sonar) == count


@pytest.mark.parametrize(
    ("name", "laser", "x_mm"),
    [
        *[("p3dx-sh-lms1xx", "lms1xx", 55), ("p3dx-sh-lms500", "lms500", 21)],
        *[("p3at-sh-lms1xx", "lms1xx", 197), ("p3at-sh-lms500", "lms500", 125)],
        *[("peoplebot-sh-lms1xx", "lms1xx", 55), ("powerbot-sh-lms500", "lms500", 251)],
        *[("amigo-sh", "none", 0), ("amigo-sh-tim3xx", "tim5xx", 110), ("p2dx", "lms2xx", 17)],
        *[("wheelchair-sh", "lms2xx", -418), ("mt400", "lms2xx", 37)],
    ],
)
def test_type_and_place_of_the_vendors_laser(name: str, laser: str, x_mm: float) -> None:
    model = load_model(name)
    assert (model.laser.type, model.laser.x) == (laser, x_mm / 1000)


def test_cut_offs_follow_the_battery() -> None:
    assert {load_model(name).battery for name in NAMES} == {12, 24}
    assert load_model("powerbot").battery == 24
    assert {load_model(name).battery for name in (*TWO_DX, *FOUR_AT, "amigo")} == {12}


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
        ("p2it", 1.136, 0.268, 625),
        ("p2pb", 0.424, 0.268, 357),
        ("p2pp", 0.485, 0.268, 333),
        ("perfpb", 0.485, 1, 333),
        ("peoplebot-sh", 1, 1, 333),
        ("patrolbot-sh", 1, 1, 357),
        ("powerbot", 0.5813, 1, 536),
        ("powerbot-sh", 1, 1, 536),
        ("amigo-sh", 1, 1, 182),
        ("seekurjr", 1, 1, 357),
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


def test_counts_of_the_first_pioneers_and_of_the_amigobot_are_no_millimetres() -> None:
    first, amigo = load_model("pion1m").conversion, load_model("amigo").conversion
    assert (first.distance, first.speed) == (5.066e-5, 2.5332e-3)
    assert (amigo.distance, amigo.speed) == (0.5083e-3, 0.6154e-3)


@pytest.mark.parametrize("name", [*TWO_DX, *FOUR_AT])
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
        load_model("p9zz")
    assert "'p9zz'" in str(failure.value)
