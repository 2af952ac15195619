"""The shipped truths, files of one's own, and what is wrong with them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from drivers.p2os.model import load_model, model_names
from tools import cli
from tools.simulation.truth.truth import TruthError, load_truth, truth_names


@pytest.mark.parametrize("name", truth_names())
def test_every_shipped_truth_loads_and_says_what_it_is(name: str) -> None:
    truth = load_truth(name)
    assert truth.name == name
    assert truth.about
    assert "\n" not in truth.about


def test_a_file_holds_only_the_differences_to_a_shipped_truth(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('like = "plain"\n[robot.laser]\nx = 0.1\n[noise]\nlaser_range = 0.03\n')
    mine, plain = load_truth(str(path)), load_truth("plain")
    assert mine.robot.laser.mount == (0.1, plain.robot.laser.y, 0.0)
    assert mine.noise.laser_range == 0.03
    assert mine.noise.sonar_range == plain.noise.sonar_range
    assert mine.robot.body == plain.robot.body


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        ('like = "plain"\n[robot.laser]\npitch = 1.0\n', r"unknown field `pitch` .*robot.laser"),
        ('like = "plain"\n[noise]\nlaser_range = -1.0\n', "noise.laser_range"),
        ('like = "plain"\n[robot.laser]\ntheta = 45.0\n', "robot.laser.theta"),
        ('like = "nowhere"\n', "like = 'nowhere': no such truth; use"),
        ("like = \n", "is not TOML"),
        ("like = 3\n", "like is not a name"),
        ('like = "plain"\n[spread.robot.laser]\nwide = 1.0\n', "spread.robot.laser.wide is"),
        ('like = "plain"\n[spread.noise]\nlaser_range = 0.5\n', "noise.laser_range"),
        (
            'like = "plain"\n[robot.silhouette]\npolygons = [[[0, 0], [0, 1], [1, 0]]]\n',
            "polygon 0 is not convex and counter-clockwise: .*robot.silhouette",
        ),
    ],
)
def test_a_wrong_file_is_refused_in_one_line_with_file_place_and_remedy(
    content: str, complaint: str, tmp_path: Path
) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(content)
    with pytest.raises(TruthError, match=complaint) as caught:
        load_truth(str(path))
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_truths_that_name_each_other_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(f'like = "{path}"\n')
    with pytest.raises(TruthError, match="goes in a circle"):
        load_truth(str(path))


def test_bench_lists_the_truths(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        cli.main(["bench", "--truth", "help"])
    assert not ended.value.code
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == truth_names()


@pytest.mark.parametrize("name", ["plane", "missing.toml"])
def test_bench_refuses_a_truth_that_is_not_there(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["bench", "--truth", name]) == 1
    assert name in capsys.readouterr().err


def test_the_housing_is_as_large_as_the_scanner() -> None:
    [corners] = load_truth("housing").robot.silhouette.polygons
    x, y = zip(*corners, strict=True)
    assert max(x) - min(x) == pytest.approx(0.156)
    assert max(y) - min(y) == pytest.approx(0.155)


@pytest.mark.parametrize("model", model_names())
def test_robots_of_every_model_that_the_driver_knows_are_no_larger_than_it_says(model: str) -> None:
    robot, believed = load_truth(model).robot, load_model(model)
    assert robot.subclass == believed.subclass
    assert robot.body.front <= believed.body.front
    assert robot.body.rear <= believed.body.rear
    assert robot.body.half_width <= 0.5 * believed.body.width
    corners = robot.body.corners or ((0.0, 0.0),)
    assert all(-robot.body.rear <= x <= robot.body.front for x, _ in corners)
    assert all(abs(y) <= robot.body.half_width for _, y in corners)


@pytest.mark.parametrize("model", ["p2at", "p2ce", "p2de", "p3at-sh", "p3dx"])
def test_robots_of_another_model_say_so_and_are_as_large_as_that_model(model: str) -> None:
    robot, usual = load_truth(model).robot, load_truth("rough").robot
    assert robot.subclass == model
    assert robot.base != usual.base
    assert (robot.body.half_width > usual.body.half_width) == ("at" in model)
    [corners] = robot.silhouette.polygons
    assert max(x for x, _ in corners) == robot.body.front


def test_every_truth_but_plain_and_ideal_is_rough_and_the_lms_111_mixes_more() -> None:
    rough = load_truth("rough")
    for name in truth_names():
        truth = load_truth(name)
        assert (truth.optics == rough.optics) == (name not in ("plain", "ideal", "lms1xx"))


def test_the_octagon_lies_in_its_body() -> None:
    robot = load_truth("octagon").robot
    [corners] = robot.silhouette.polygons
    assert len(corners) == 8
    assert all(-robot.body.rear <= x <= robot.body.front for x, _ in corners)
    assert all(math.fabs(y) <= robot.body.half_width for _, y in corners)


def test_a_spread_is_drawn_anew_for_each_robot_within_its_bounds() -> None:
    rough = load_truth("rough")
    rng = np.random.default_rng(1)
    lasers = [rough.drawn(rng).robot.laser for _ in range(50)]
    x = np.array([laser.x for laser in lasers])
    assert np.ptp(x) > 0.015
    assert np.abs(x - rough.robot.laser.x).max() <= 0.01
    assert max(abs(laser.theta) for laser in lasers) <= math.radians(1.0) + 1e-6
    assert {laser.mirrored for laser in lasers} == {False}


def test_a_truth_without_spread_draws_nothing() -> None:
    rng = np.random.default_rng(1)
    plain = load_truth("plain")
    assert plain.drawn(rng) is plain
    assert rng.random() == np.random.default_rng(1).random()


def test_a_spread_stays_about_the_value_of_a_truth_that_is_like_it(tmp_path: Path) -> None:
    path = tmp_path / "turned.toml"
    path.write_text('like = "rough"\n[robot.laser]\ntheta = 1.0\n')
    theta = load_truth(str(path)).drawn(np.random.default_rng(1)).robot.laser.theta
    assert theta != 1.0
    assert abs(theta - 1.0) < math.radians(1.01)
