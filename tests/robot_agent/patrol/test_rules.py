"""The shipped rule file against the paper's Table I, and what the loader refuses."""

import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from skfuzzy.membership import trapmf, trimf

from robot_agent.patrol.actions import Action
from robot_agent.patrol.rules import (
    RULES_FILE,
    RulesError,
    _fuzzy_set,
    check_rules,
    load_rules,
)

ATL, RFL, KGL, PCWL, PCCWL = (
    Action.AVOID_TEAMMATE,
    Action.REACH_FRONTIER,
    Action.KEEP_GOING,
    Action.PATROL_CLOCKWISE,
    Action.PATROL_COUNTER_CLOCKWISE,
)
# Full membership of one set of each input.
BORDER = {"low": 0.1, "medium": 1.0, "high": 3.0}
NEIGHBOR = {"low": 0.5, "medium": 1.4, "high": 3.0}
STATE = {"left": -1.0, "not": 0.0, "right": 1.0}

# Table I, one line per cell: outputs that are not low. R1 in the damaged cell.
TABLE = """
high   left   low     ATL high
high   left   medium  ATL high
high   left   high    RFL high
high   not    low     ATL high
high   not    medium  ATL high
high   not    high    RFL high
high   right  low     ATL high
high   right  medium  ATL high
high   right  high    RFL high
medium left   low     ATL high
medium left   medium  ATL high PCWL medium
medium left   high    KGL high
medium not    low     ATL high
medium not    medium  ATL medium KGL high
medium not    high    KGL high
medium right  low     ATL high
medium right  medium  ATL high PCCWL medium
medium right  high    RFL high
low    left   low     ATL high
low    left   medium  PCWL high
low    left   high    KGL high
low    not    low     ATL high
low    not    medium  KGL high
low    not    high    KGL high
low    right  low     ATL high
low    right  medium  PCCWL high
low    right  high    KGL high
"""
NAMES = {"ATL": ATL, "RFL": RFL, "KGL": KGL, "PCWL": PCWL, "PCCWL": PCCWL}
# Centroids of the full triangles (0, 0, 0.5), (0, 0.5, 1), (0.5, 1, 1).
CENTROID = {"low": 1.0 / 6.0, "medium": 0.5, "high": 5.0 / 6.0}


def degrees(border, neighbor, state, *, reading="R1", open_border=False, left=9.0, right=9.0):
    system = load_rules(RULES_FILE, reading=reading, safety_distance=2.4, open_border=open_border)
    return system.evaluate(
        {
            "distance_from_border": border,
            "distance_from_neighbor": neighbor,
            "neighbor_state": state,
            "distance_from_left_end": left,
            "distance_from_right_end": right,
        }
    )


@pytest.mark.parametrize("line", TABLE.strip().splitlines())
def test_cell_of_table_one(line):
    border, state, neighbor, *words = line.split()
    named = {NAMES[n]: level for n, level in zip(words[::2], words[1::2], strict=True)}
    found = degrees(BORDER[border], NEIGHBOR[neighbor], STATE[state])
    assert found == pytest.approx({action: CENTROID[named.get(action, "low")] for action in Action})


def test_there_are_27_rules():
    closed = load_rules(RULES_FILE, reading="R1", safety_distance=2.4, open_border=False)
    assert len(closed.rules) == 27


@pytest.mark.parametrize(
    ("reading", "left", "right"), [("R1", KGL, RFL), ("R2", RFL, RFL), ("R3", KGL, KGL)]
)
def test_readings_of_the_damaged_cell(reading, left, right):
    for state, winner in ((-1.0, left), (1.0, right)):
        found = degrees(1.0, 3.0, state, reading=reading)
        assert max(found, key=found.__getitem__) == winner


def winner(*args, **kwargs):
    found = degrees(*args, **kwargs)
    return max(found, key=found.__getitem__)


@pytest.mark.parametrize(
    ("below", "above", "inputs"),
    [
        (KGL, RFL, lambda x: (1.5 + x, 3.0, 0.0)),  # alone
        (ATL, PCWL, lambda x: (0.0, 1.1 + x, -1.0)),  # a patrolling teammate
        (PCWL, KGL, lambda x: (0.0, 1.9 + x, -1.0)),
        (PCCWL, KGL, lambda x: (0.0, 1.9 + x, 0.5)),
        (ATL, KGL, lambda x: (0.0, 1.1 + x, 0.0)),  # one that is not patrolling
        (PCCWL, KGL, lambda x: (0.0, 1.5, 0.375 - x)),
    ],
)
def test_decision_boundaries(below, above, inputs):
    assert winner(*inputs(-0.01)) == below
    assert winner(*inputs(0.01)) == above


def test_ends_of_an_open_border():
    near, far = 0.1, 5.0
    for border in (0.1, 1.0):
        for neighbor in (1.5, 3.0):
            assert winner(border, neighbor, 0.0, open_border=True, left=near) == PCWL
            assert winner(border, neighbor, 0.0, open_border=True, right=near) == PCCWL
    assert winner(0.1, 0.5, 0.0, open_border=True, left=near) == ATL
    assert winner(3.0, 3.0, 0.0, open_border=True, left=near) == RFL
    assert winner(0.1, 3.0, 0.0, open_border=True, left=far) == KGL
    # Keep Going is as low as it gets near an end.
    assert degrees(0.1, 3.0, 0.0, open_border=True, left=near)[KGL] == pytest.approx(1 / 6)


def test_far_from_the_ends_an_open_border_equals_a_closed_one():
    for border in (0.1, 0.7, 1.2, 3.0):
        for neighbor in (0.5, 1.2, 1.7, 3.0):
            for state in (-1.0, -0.3, 0.0, 0.5):
                assert degrees(border, neighbor, state, open_border=True) == pytest.approx(
                    degrees(border, neighbor, state)
                )


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (r"low = \[0.0, 0.0, 0.4, 1.0\]", "low = [0.0, 0.4, 0.0, 1.0]", "do not ascend"),
        (r"low = \[0.0, 0.0, 0.4, 1.0\]", "low = [0.0, 1.0]", "give 3 numbers"),
        (r"low = \[0.0, 0.0, 0.4, 1.0\]", "low = [0.0, 0.0, 0.2, 0.4]", "no set covers 0.4"),
        (r"low = \[0.0, 0.0, 0.4, 1.0\]", "small = [0.0, 0.0, 0.4, 1.0]", "unknown name 'small'"),
        (r"low = \[0.0, 0.0, 0.4, 1.0\].*\n", "", "low is missing"),
        (r"high = \[1.0, 2.0, inf, inf\]", "high = [1.0, 2.0, 5.0, 5.0]", "no set covers inf"),
        (r"low = \[0.0, 0.0, 0.5\]", "low = [-0.5, 0.0, 0.5]", "leaves 0 to 1"),
        (r"\[sets.level\]", "[sets.grade]", "unknown name 'grade'"),
        (r'neighbor_low = "ATL high"', 'neighbor_low = "XTL high"', "is no output and level"),
        (r'neighbor_low = "ATL high"', 'neighbor_low = "ATL huge"', "is no output and level"),
        (r'neighbor_low = "ATL high"', "neighbor_low = 3", "is no output and level"),
        (r'neighbor_low = "ATL high"\n', "", "neighbor_low is missing, add the cell"),
        (
            r'neighbor_low = "ATL high"',
            'neighbour_low = "ATL high"',
            "unknown name 'neighbour_low'",
        ),
        (r"border_high.not_patrolling", "border_high.patrolling", "unknown name 'patrolling'"),
        (r"\[reading.R1.border_medium", "[reading.R9.border_medium", "unknown name 'R9'"),
        (r'left_end_low = "PCWL high"\n', "", "left_end_low is missing"),
        (r'border = \["low", "medium"\]', 'border = ["near"]', "list some of"),
        (r"\[sets.level\]", "[sets]\nlevel = 1\n[other]", "unknown name 'other'"),
        (r"\[sets.level\]", "[border_high]\nnot_patrolling = 1\n[sets.level]", "TOML"),
        (r"reading.R2.border_medium.*\n.*\n", "reading]\nR2 = 3\n", "no table, write it as"),
        (r"\[sets.level\]", "[sets.level", "give a readable TOML file"),
        # a gap that touches no corner: both sets end upright
        (
            r"low = \[0.0, 0.0, 0.3, 0.8\]\nhigh = \[0.3",
            "low = [0.0, 0.0, 0.3, 0.3]\nhigh = [0.8",
            "no set covers 0.55",
        ),
        (r"medium = \[0.4, 1.0, 2.0\]", "medium = [0.4, 3.0, 4.0]", "medium lies above high"),
        (
            r"patrolling_on_my_right = \[0.0, 0.75, 1.0, 1.0\]",
            "patrolling_on_my_right = [0.0, 1.75, 2.0, 2.0]",
            r"\[border_low.patrolling_on_my_right\] neighbor_low: can never hold: "
            r"\[sets.neighbor_state\] patrolling_on_my_right is full only outside -1 to 1",
        ),
        (
            r"low = \[0.0, 0.0, 0.3, 0.8\]",
            "low = [-2.0, -2.0, -0.3, 0.8]",
            r"\[open_border\] left_end_low: can never hold: \[sets.distance_from_left_end\] low",
        ),
        (
            r'neighbor_low = "ATL high"',
            'neighbor_low = "ATL low, KGL low"',
            r"\[border_high.patrolling_on_my_left\] neighbor_low: chooses nothing",
        ),
        (r'neighbor_low = "ATL high"', 'neighbor_low = "ATL high, ATL low"', "says ATL twice"),
        (
            r'neighbor_high = "RFL high"',
            'neighbor_high = "ATL high"',
            r"\[border_high.patrolling_on_my_left\] neighbor_high: avoids a teammate however far",
        ),
        (r'left_end_low = "PCWL high"', 'left_end_low = "PCWL low"', "left_end_low: chooses"),
    ],
)
def test_error_names_file_place_and_remedy(tmp_path, old, new, message):
    text, count = re.subn(old, new, RULES_FILE.read_text(), count=1)
    assert count == 1
    path = tmp_path / "mine.toml"
    path.write_text(text)
    with pytest.raises(RulesError, match=message) as caught:
        load_rules(path, reading="R1", safety_distance=2.4, open_border=True)
    line = str(caught.value)
    assert line.startswith(f"{path}: ")
    assert "\n" not in line
    assert "," in line or ";" in line  # "problem, remedy"


@pytest.mark.parametrize("junk", ["3", "[]", "[[1]]", '"x"', "{}", "nan", "[nan, 0, 0]", "true"])
def test_any_wrong_value_raises_rules_error(tmp_path, junk):
    """Any wrong type in place of one value or one table raises RulesError, no other error."""
    lines = RULES_FILE.read_text().splitlines()
    path = tmp_path / "mine.toml"
    for i, line in enumerate(lines):
        if line.startswith("["):
            changed = f"{line.split(']')[0][1:]} = {junk}"
        elif "=" in line and not line.startswith("#"):
            changed = f"{line.split('=')[0]}= {junk}"
        else:
            continue
        path.write_text("\n".join([*lines[:i], changed, *lines[i + 1 :]]))
        with pytest.raises(RulesError, match=re.escape(f"{path}: ")):
            load_rules(path, reading="R1", safety_distance=2.4, open_border=True)


@pytest.mark.parametrize("points", ["[1.0, 1.2, 2.0, inf]", "[-inf, 0.0, 0.4, 1.0]"])
def test_fuzzy_set_with_an_infinite_side_raises(tmp_path, points):
    path = tmp_path / "mine.toml"
    text, count = re.subn(
        r"(?m)^low = .*1\.0\].*meets.*$", f"low = {points}", RULES_FILE.read_text()
    )
    assert count == 1
    path.write_text(text)
    with pytest.raises(RulesError, match=r"distance_from_border\] low: gives no degree at "):
        load_rules(path, reading="R1", safety_distance=2.4, open_border=False)


POINTS = st.floats(-4.0, 4.0).map(lambda x: round(x, 2)) | st.floats(-4.0, 4.0, width=32)


@given(st.lists(POINTS, min_size=3, max_size=4).map(sorted), st.lists(POINTS), st.booleans())
def test_fuzzy_sets_are_bit_identical_to_skfuzzy(points, places, shoulder):
    if shoulder and len(points) == 4:
        points = [*points[:2], math.inf, math.inf]
    exact = _fuzzy_set(points)
    places = [*places, *(x for x in points if math.isfinite(x))]
    theirs = (trapmf if len(points) == 4 else trimf)(np.array(places), np.array(points))
    assert [exact(x) for x in places] == theirs.tolist()


def test_missing_reading_raises(tmp_path):
    path = tmp_path / "mine.toml"
    text, count = re.subn(r"\[reading\.R2[^\[]*", "", RULES_FILE.read_text())
    assert count == 1
    path.write_text(text)
    with pytest.raises(RulesError, match=r"\[reading\]: has no R2, add it"):
        load_rules(path, reading="R2", safety_distance=2.4, open_border=False)


def test_missing_file_raises(tmp_path):
    with pytest.raises(RulesError, match="No such file"):
        load_rules(tmp_path / "none.toml", reading="R1", safety_distance=2.4, open_border=False)


def test_complete_table_without_readings_loads(tmp_path):
    text = RULES_FILE.read_text()
    text = text[: text.index("# Three readings")] + text[text.index("[open_border]") :]
    text = text.replace(
        "# neighbor_high is damaged in print, see the readings below", 'neighbor_high = "RFL high"'
    )
    path = tmp_path / "mine.toml"
    path.write_text(text)
    system = load_rules(path, reading="R1", safety_distance=2.4, open_border=False)
    assert len(system.rules) == 27


def test_safety_distance_inside_the_avoiding_zone_raises():
    load_rules(RULES_FILE, reading="R1", safety_distance=1.9, open_border=False)
    with pytest.raises(RulesError, match=r"cross at 1\.90 m.*raise safety_distance"):
        load_rules(RULES_FILE, reading="R1", safety_distance=1.89, open_border=False)


def test_check_covers_every_reading(tmp_path):
    """A fault in R3 alone does not affect R1, but the check finds it."""
    check_rules(RULES_FILE, safety_distance=2.4)
    text = RULES_FILE.read_text()
    start = text.index("[reading.R3.border_medium.patrolling_on_my_right]")
    path = tmp_path / "mine.toml"
    path.write_text(text[:start] + text[start:].replace("KGL high", "KGL low", 1))
    load_rules(path, reading="R1", safety_distance=2.4, open_border=False)
    with pytest.raises(RulesError, match=r"border_medium.*right\] neighbor_high: chooses nothing"):
        check_rules(path, safety_distance=2.4)
