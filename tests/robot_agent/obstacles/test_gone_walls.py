"""Walls of the map that the laser has seen through."""

import numpy as np
import pytest

from robot_agent.obstacles.gone_walls import GoneWalls

CELLS = np.array([7, 12, 30], dtype=np.intp)
PLACES = np.array([(0.5, 0.0), (0.5, 0.3), (0.0, -0.6)])
NO_ECHOES = np.empty((0, 2))
FAR = np.full(3, 2.0)  # m that beams go beyond each
UNSEEN = np.full(3, -np.inf)


def looked(
    walls: GoneWalls,
    times: int = 1,
    *,
    at: np.ndarray = FAR,
    aside: np.ndarray | None = None,
    echoes: np.ndarray = NO_ECHOES,
) -> list[int]:
    """Return the cells that are gone after a number of scans."""
    for _ in range(times):
        walls.update(CELLS, PLACES, (at, at if aside is None else aside), echoes)
    return walls.cells.tolist()


def test_a_wall_is_gone_once_three_scans_have_seen_through_it_and_stays_so_out_of_view() -> None:
    walls = GoneWalls()
    assert looked(walls, 2) == []
    assert looked(walls) == [7, 12, 30]
    assert looked(walls, 50, at=UNSEEN) == [7, 12, 30]


def test_a_beam_that_passes_beside_a_frame_shows_nothing() -> None:
    assert looked(GoneWalls(), 9, aside=np.array([2.0, 0.1, -0.4])) == [7]


@pytest.mark.parametrize("shift", [-0.05, 0.0, 0.05])
def test_a_wall_that_is_seen_is_back_at_once(shift: float) -> None:
    walls = GoneWalls()
    looked(walls, 30)
    assert looked(walls, at=np.array([shift, 2.0, -np.inf])) == [12, 30]


def test_something_before_a_wall_tells_nothing_of_it() -> None:
    walls = GoneWalls()
    looked(walls, 30)
    assert looked(walls, at=np.array([-0.4, 2.0, 2.0])) == [7, 12, 30]


def test_glass_that_sonars_hear_is_never_gone_and_comes_back() -> None:
    glass = np.array([(0.55, 0.1), (3.0, 0.0)])
    walls = GoneWalls()
    assert looked(walls, 30, echoes=glass) == [30]
    looked(walls, 30)
    assert looked(walls, 2, at=UNSEEN, echoes=glass) == [7, 12, 30], "one false echo does not count"
    assert looked(walls, 9, at=UNSEEN, echoes=glass) == [30]


def test_cells_no_longer_near_are_forgotten() -> None:
    walls = GoneWalls()
    looked(walls, 9)
    walls.update(CELLS[1:], PLACES[1:], (UNSEEN[1:], UNSEEN[1:]), NO_ECHOES)
    assert looked(walls, at=UNSEEN) == [12, 30]
    walls.forget()
    assert looked(walls, at=UNSEEN) == []
