"""Paths round walls: lengths, directions, line of sight, and where there is no path."""

import math
import time
from pathlib import Path

import numpy as np
import pytest

from maps.approach_field import TWO_WHEELED_PIONEER, ApproachField, BodySize
from maps.border import Border
from maps.border_primitives import Segment
from maps.map_folder import load_map_folder
from maps.occupancy_map import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from maps.pose import Pose

CELL = 0.05
LINE = Border([Segment((1.0, 1.0), (9.0, 1.0))], closed=False)
PAPER_LAB = Path(__file__).parents[2] / "maps" / "paper_lab"


def hall(*walls: tuple[float, float, float, float]) -> OccupancyMap:
    """10 x 6 m, walled in; further walls as x0, y0, x1, y1."""
    cells = np.full((round(6 / CELL), round(10 / CELL)), FREE, dtype=np.uint8)
    cells[[0, -1], :] = OCCUPIED
    cells[:, [0, -1]] = OCCUPIED
    for wall in walls:
        c0, r0, c1, r1 = (round(v / CELL) for v in wall)
        cells[r0:r1, c0:c1] = OCCUPIED
    return OccupancyMap(cells, CELL, Pose(0.0, 0.0, 0.0))


def ask(field: ApproachField, x: float, y: float):
    foot = LINE.project(x, y)
    return field.around_walls(x, y, (foot.x, foot.y))


def test_border_in_sight_has_no_path():
    field = ApproachField(hall((0.0, 2.0, 4.0, 2.2)), LINE)
    assert ask(field, 6.0, 4.0) is None
    assert ask(field, 6.0, 1.0) is None
    assert ask(field, 2.0, 1.2) is None  # on the border's side of the wall


def test_path_leads_round_the_end_of_a_wall():
    field = ApproachField(hall((0.0, 2.0, 5.0, 2.2)), LINE)
    x, y = 3.0, 2.8
    found = ask(field, x, y)
    assert found is not None
    # Taut string round the wall's end grown by 0.40 m, then straight down.
    corner = (5.0, 2.2 + 0.4)
    taut = math.dist((x, y), corner) + 0.4 * math.pi / 2 + 2.2 - 1.0
    assert found.distance == pytest.approx(taut, rel=0.06)
    heading = math.atan2(found.direction[1], found.direction[0])
    assert heading == pytest.approx(math.atan2(corner[1] - y, corner[0] - x), abs=0.25)
    assert math.hypot(*found.direction) == pytest.approx(1.0)


def test_following_the_path_arrives_clear_of_walls():
    """A point that follows the direction gets a line of sight; the path only gets shorter."""
    occupancy = hall((0.0, 2.0, 5.0, 2.2), (6.0, 3.6, 10.0, 3.8), (5.0, 2.0, 5.2, 4.8))
    field = ApproachField(occupancy, LINE)
    room = occupancy.distance_field()
    x, y = 1.0, 3.0
    ways = []
    while (found := ask(field, x, y)) is not None:
        ways.append(found.distance)
        x, y = x + 0.05 * found.direction[0], y + 0.05 * found.direction[1]
        (row,), (col,) = occupancy.cells_at((x, y))
        assert room[row, col] > 0.34  # 0.40 m less a cell
        assert len(ways) < 300
    assert ways[0] > 7.0
    assert max(np.diff(ways)) < CELL  # lengths are known per cell
    assert ways[0] - ways[-1] == pytest.approx(0.05 * (len(ways) - 1), rel=0.06)
    assert LINE.project(x, y).distance > 1.0  # sight came before the border


def test_closed_room_and_too_narrow_gap_have_no_path():
    for gap in (0.0, 0.5):
        field = ApproachField(hall((0.0, 2.0, 10.0 - gap, 2.2)), LINE)
        found = ask(field, 3.0, 3.0)
        assert found is not None
        assert found.distance == math.inf
        assert found.direction == (0.0, 0.0)


def test_wider_path_is_preferred_to_a_narrow_one():
    narrow = (3.0, 3.65)  # 0.65 m, room for the body but not for a turn
    one = ApproachField(hall((0.0, 2.0, 3.0, 2.2), (3.65, 2.0, 10.0, 2.2)), LINE)
    found = ask(one, 2.0, 3.0)
    assert found is not None
    assert math.isfinite(found.distance)
    two = ApproachField(
        hall((0.0, 2.0, 3.0, 2.2), (narrow[1], 2.0, 4.5, 2.2), (5.5, 2.0, 10.0, 2.2)), LINE
    )
    wide = ask(two, 4.3, 2.8)
    assert wide is not None
    assert wide.direction[0] > 0.5


@pytest.mark.parametrize("aside", [-0.07, -0.04, 0.0, 0.03, 0.06])
def test_a_long_body_beside_the_middle_of_a_door_is_led_through_nearly_straight(aside: float):
    """Turned by 45 degrees, towards the next cell, its corner would meet the frame."""
    body = BodySize(0.4285, 0.25)
    field = ApproachField(hall((0.0, 2.0, 4.0, 2.2), (4.95, 2.0, 10.0, 2.2)), LINE, body)
    for y in (2.3, 2.4, 2.5, 2.6):
        found = ask(field, 4.475 + aside, y)
        assert found is None or abs(found.direction[0]) < 0.45  # 27 degrees


def test_path_exists_against_a_wall_and_not_off_the_map():
    field = ApproachField(hall((0.0, 2.0, 5.0, 2.2)), LINE)
    touching = ask(field, 2.0, 2.35)
    assert touching is not None
    assert math.isfinite(touching.distance)
    outside = ask(field, -1.0, 3.0)
    assert outside is not None
    assert outside.distance == math.inf


def test_unknown_cells_are_not_passed():
    occupancy = hall()
    occupancy.cells[40:44, :] = UNKNOWN
    found = ask(ApproachField(occupancy, LINE), 3.0, 3.0)
    assert found is not None
    assert found.distance == math.inf


def test_same_map_gives_the_same_field():
    one, other = (ApproachField(hall((0.0, 2.0, 5.0, 2.2)), LINE) for _ in range(2))
    for x in np.linspace(0.5, 5.0, 30):
        assert ask(one, float(x), 3.0) == ask(other, float(x), 3.0)


def test_clearances_follow_the_size_of_the_body():
    assert TWO_WHEELED_PIONEER.turning_clearance == 0.40
    assert TWO_WHEELED_PIONEER.passing_clearance == 0.30
    large = BodySize(0.6401, 0.34)
    assert (large.turning_clearance, large.passing_clearance) == (0.68, 0.42)
    round_one = BodySize(0.25, 0.25)
    assert (round_one.turning_clearance, round_one.passing_clearance) == (0.33, 0.33)


def test_gap_that_only_a_small_body_passes_is_a_way_for_that_one_alone():
    occupancy = hall((0.0, 2.0, 2.6, 2.2), (3.4, 2.0, 10.0, 2.2))
    small = ask(ApproachField(occupancy, LINE), 3.0, 3.0)
    large = ask(ApproachField(occupancy, LINE, BodySize(0.6401, 0.34)), 3.0, 3.0)
    assert large is not None
    assert large.distance == math.inf
    assert small is None or small.distance < math.inf


def test_way_leads_through_the_middle_of_doors_and_never_along_their_frames():
    for left, right in ((3.0, 3.65), (3.0, 3.9)):  # too narrow to turn in, and wide enough
        field = ApproachField(hall((0.0, 2.0, left, 2.2), (right, 2.0, 10.0, 2.2)), LINE)
        x, y = right - 0.31, 3.0  # from here a straight line passes the frame
        while y > 2.1:
            found = ask(field, x, y)
            dx, dy = found.direction if found else (0.0, -1.0)
            x, y = x + 0.02 * dx, y + 0.02 * dy
        assert abs(x - 0.5 * (left + right)) < 0.06


def test_paper_lab_has_a_path_from_every_room_and_is_fast():
    folder = load_map_folder(PAPER_LAB)
    started = time.process_time()
    field = folder.approach_field
    spent = time.process_time() - started
    assert field is not None
    assert folder.approach_field is field  # computed once for all robots
    assert spent < 5.0  # 0.5 s on our slow machine; this is to catch a blow-up
    assert folder.border is not None
    rooms = [(1.0, 1.3), (1.0, 5.6), (1.6, 9.0), (1.4, 16.0), (3.5, 16.2), (7.0, 16.0)]
    rooms += [(12.0, 16.2), (14.5, 16.5), (18.0, 13.0), (23.9, 16.5), (23.5, 10.5), (23.3, 6.5)]
    rooms += [(23.3, 4.5), (23.3, 1.5), (20.0, 1.6), (16.0, 1.5), (13.0, 1.5), (8.0, 1.6)]
    rooms += [(7.6, 9.2), (6.3, 6.5), (12.0, 11.0), (16.5, 7.8)]
    hidden = 0
    for x, y in rooms:
        foot = folder.border.project(x, y)
        found = field.around_walls(x, y, (foot.x, foot.y))
        if found is not None:
            hidden += 1
            assert math.isfinite(found.distance), (x, y)
            assert found.distance > foot.distance - 0.1
    assert hidden > 15
