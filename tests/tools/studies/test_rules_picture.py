"""``patrol rules``: the picture of the rule base, and its check from the command line."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from robot_agent.patrol.actions import Action
from robot_agent.patrol.rules import RULES_FILE, load_rules
from tools.cli import main
from tools.studies.rules_picture import decision_map

FAR = {"distance_from_left_end": np.inf, "distance_from_right_end": np.inf}


def winners(gamma, borders, neighbors, reading="R1"):
    system = load_rules(RULES_FILE, reading=reading, safety_distance=2.4, open_border=False)
    found = decision_map(system, np.array(borders), np.array(neighbors), gamma, FAR)
    return [[tuple(Action)[i] for i in row] for row in found]


def test_decision_map_has_the_boundaries_of_the_rules():
    atl, rfl, kgl = Action.AVOID_TEAMMATE, Action.REACH_FRONTIER, Action.KEEP_GOING
    cw, ccw = Action.PATROL_CLOCKWISE, Action.PATROL_COUNTER_CLOCKWISE
    borders, neighbors = (0.1, 1.51), (1.09, 1.11, 1.91)
    assert winners(0.0, borders, neighbors) == [[atl, atl], [kgl, atl], [kgl, rfl]]
    assert winners(-1.0, borders, neighbors) == [[atl, atl], [cw, atl], [kgl, rfl]]
    assert winners(1.0, borders, neighbors) == [[atl, atl], [ccw, atl], [kgl, rfl]]
    assert winners(-1.0, (1.0,), (2.5,), "R1") == [[kgl]]
    assert winners(-1.0, (1.0,), (2.5,), "R2") == [[rfl]]


@pytest.mark.parametrize("words", [[], ["--open"]])
def test_show_writes_a_picture_with_every_action_in_its_color(tmp_path, capsys, words):
    png = tmp_path / "new" / "rules.png"
    assert main(["rules", "show", *words, "-o", str(png)]) == 0
    assert capsys.readouterr().out.strip() == str(png)
    picture = cv2.imread(str(png))
    colors = {tuple(c) for c in picture.reshape(-1, 3)[::7].tolist()}
    for blue_green_red in (
        (0xAA, 0x77, 0x44),
        (0x44, 0xBB, 0xCC),
        (0x33, 0x88, 0x22),
        (0x77, 0x33, 0xAA),
        (0x77, 0x66, 0xEE),
    ):
        assert blue_green_red in colors


def test_check_prints_ok_or_the_error(tmp_path: Path, capsys):
    assert main(["rules", "check", str(RULES_FILE)]) == 0
    assert capsys.readouterr().out == f"{RULES_FILE}: OK\n"
    bad = tmp_path / "bad.toml"
    bad.write_text(RULES_FILE.read_text().replace('neighbor_low = "ATL high"', "", 1))
    assert main(["rules", "check", str(bad)]) == 1
    caught = capsys.readouterr()
    assert caught.out == ""
    assert caught.err.count("\n") == 1
    assert "[border_high.patrolling_on_my_left]: neighbor_low is missing" in caught.err
    assert main(["rules", "check", str(RULES_FILE), "--safety-distance", "1.5"]) == 1
    assert "cross at 1.90 m" in capsys.readouterr().err
