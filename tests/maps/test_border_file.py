"""Border files."""

from __future__ import annotations

import math

import pytest

from maps.border import BorderError
from maps.border_file import read_border

VERTICES = """
closed = true
corner_radius = 1.0
vertices = [[0, 0], [10.0, 0.0, 2.0], [10, 6], [0, 6]]
"""
# A stadium, its pieces out of order and counter-clockwise.
STADIUM = """
closed = true
[[segment]]
from = [0.0, 0.0]
to = [4.0, 0.0]
[[segment]]
from = [4.0, 2.0]
to = [0.0, 2.0]
[[arc]]
from = [0.0, 2.0]
to = [0.0, 0.0]
center = [0.0, 1.0]
turn = "left"
[[arc]]
from = [4.0, 0.0]
to = [4.0, 2.0]
center = [4.0, 1.0]
turn = "left"
"""
S_CURVE = """
closed = false
[[segment]]
from = [6.0, 4.0]
to = [9.0, 4.0]
[[segment]]
from = [0.0, 0.0]
to = [4.0, 0.0]
[[arc]]
from = [5.0, 3.0]
to = [6.0, 4.0]
center = [6.0, 3.0]
turn = "right"
[[arc]]
from = [4.0, 0.0]
to = [5.0, 1.0]
center = [4.0, 1.0]
turn = "left"
[[segment]]
from = [5.0, 1.0]
to = [5.0, 3.0]
"""


def test_vertices_may_have_a_common_or_an_own_radius() -> None:
    border = read_border(VERTICES.encode(), "border.toml")
    assert border.closed
    assert border.length == pytest.approx(32.0 - (2.0 - math.pi / 2) * (3 * 1.0 + 2.0))


def test_pieces_are_chained_and_turned_clockwise() -> None:
    border = read_border(STADIUM.encode(), "stadium.toml")
    assert border.length == pytest.approx(8.0 + 2.0 * math.pi)
    assert border.at(0.0)[:2] == pytest.approx((0.0, 0.0))
    assert border.project(2.0, 2.5).tangent == pytest.approx((1.0, 0.0))
    assert border.project(2.0, -0.5).tangent == pytest.approx((-1.0, 0.0))


def test_open_chain_starts_at_the_piece_without_predecessor() -> None:
    border = read_border(S_CURVE.encode(), "s.toml")
    assert not border.closed
    assert border.length == pytest.approx(4.0 + 2.0 + 3.0 + math.pi)
    assert border.at(0.0)[:2] == pytest.approx((0.0, 0.0))
    assert border.at(border.length)[:2] == pytest.approx((9.0, 4.0))
    assert [math.copysign(1, p.curvature) for p in border.primitives if p.curvature] == [1, -1]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("closed = true\n", ["give either"]),
        (VERTICES + STADIUM.replace("closed = true", ""), ["give either"]),
        (STADIUM.replace("true", "true\ncorner_radius = 1.0", 1), ["belongs to 'vertices'"]),
        (VERTICES.replace("corner_radius = 1.0", ""), ["vertex 1 has no radius"]),
        (VERTICES.replace("2.0]", "-2.0]"), ["vertex 2", "-2 m", "positive"]),
        (VERTICES.replace("corner_radius = 1.0", "corner_radius = 0"), ["corner_radius"]),
        (VERTICES.replace("corner_radius", "cornerradius"), ["cornerradius"]),
        (VERTICES.replace("closed = true", ""), ["closed"]),
        (VERTICES.replace("[0, 0]", "[0]"), ["vertices"]),
        (VERTICES.replace("[0, 0]", "[nan, 0]"), ["border.toml"]),
        (VERTICES.replace("2.0]", "20.0]"), ["vertices", "make their radii smaller"]),
        (STADIUM.replace("to = [4.0, 0.0]", "to = [3.0, 0.0]"), ["primitive 1", "1.000 m from"]),
        (STADIUM.replace("center = [4.0, 1.0]", "center = [4.0, 1.2]"), ["arc 2", "center"]),
        (STADIUM.replace('turn = "left"', 'turn = "right"', 1), ["180.0 degrees"]),
        (STADIUM.replace("true", "false"), ["set closed = true"]),
        (S_CURVE.replace("from = [5.0, 1.0]", "from = [5.0, 1.5]"), ["make the pieces meet"]),
        (S_CURVE.replace("turn", "bend"), ["bend"]),
        ("closed = [", ["border.toml"]),
    ],
)
def test_invalid_file_gives_one_line_with_file_and_place(text: str, words: list[str]) -> None:
    with pytest.raises(BorderError) as caught:
        read_border(text.encode(), "border.toml")
    message = str(caught.value)
    assert message.startswith("border.toml: ")
    assert "\n" not in message
    for word in words:
        assert word in message


def test_binary_file_is_a_border_error() -> None:
    with pytest.raises(BorderError, match=r"border\.toml"):
        read_border(b"\xff\xfe\x00", "border.toml")


def test_a_straight_open_border_needs_no_radius() -> None:
    border = read_border(b"closed = false\nvertices = [[0.0, 0.0], [5.0, 0.0]]\n", "b.toml")
    assert border.length == pytest.approx(5.0)
    with pytest.raises(BorderError, match="vertex 2 has no radius"):
        read_border(b"closed = false\nvertices = [[0.0, 0.0], [5.0, 0.0], [5.0, 5.0]]\n", "b.toml")
