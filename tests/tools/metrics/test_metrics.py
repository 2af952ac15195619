"""Figures of a run, on runs small enough to work out by hand."""

import numpy as np
import pytest

from maps.border import Border
from maps.map_folder import load_map_folder
from robot_agent.config import find_map
from robot_agent.patrol.actions import Action
from tools.metrics.metrics import (
    RobotRun,
    action_share,
    bench_figures,
    closest_approach,
    distance_from_border,
    interferences,
    longest_avoid,
    meetings,
    patrolling_distances,
    reach_time,
)

STEP = 0.1


@pytest.fixture(scope="module")
def border(tmp_path_factory: pytest.TempPathFactory) -> Border:
    folder = load_map_folder(find_map("paper_lab", tmp_path_factory.mktemp("none")))
    assert folder.border is not None
    return folder.border


def run_along(
    border: Border,
    abscissae: np.ndarray,
    *,
    name: str = "robot1",
    aside: float = 0.0,
    action: str = Action.KEEP_GOING,
    direction: int = 1,
) -> RobotRun:
    """Return a run at given abscissae, m, one per step, ``aside`` m left of the border."""
    places = [border.at(float(s % border.length)) for s in abscissae]
    return RobotRun(
        name=name,
        t=np.arange(len(places)) * STEP,
        position=np.array([(p.x - aside * p.ty, p.y + aside * p.tx) for p in places]),
        action=[action] * len(places),
        direction=np.full(len(places), direction, dtype=np.int8),
    )


def test_distances_count_from_the_first_arrival(border: Border) -> None:
    far = run_along(border, np.full(10, 3.0), aside=0.5)
    near = run_along(border, np.full(10, 3.0), aside=0.04)
    run = RobotRun(
        name="robot1",
        t=np.arange(20) * STEP,
        position=np.concatenate([far.position, near.position]),
        action=[*far.action, *near.action],
        direction=np.ones(20, dtype=np.int8),
    )
    distance = distance_from_border(border, run)
    assert reach_time(run, distance) == pytest.approx(1.0)
    assert patrolling_distances(run, distance) == pytest.approx(np.full(10, 0.04), abs=1e-3)


def test_a_robot_that_never_arrives_has_no_distances(border: Border) -> None:
    run = run_along(border, np.full(10, 3.0), aside=0.5)
    distance = distance_from_border(border, run)
    assert reach_time(run, distance) is None
    assert patrolling_distances(run, distance).size == 0


def test_distances_outside_patrol_actions_are_left_out(border: Border) -> None:
    run = run_along(border, np.full(10, 3.0), action=Action.AVOID_TEAMMATE)
    assert patrolling_distances(run, distance_from_border(border, run)).size == 0
    assert longest_avoid([run]) == pytest.approx(0.9)
    assert action_share([run])["avoid_teammate"] == 1.0


def test_interference_is_counted_once_in_ten_seconds(border: Border) -> None:
    still = run_along(border, np.full(250, 10.0))
    near = run_along(border, np.full(250, 11.9), name="robot2")
    far = run_along(border, np.full(250, 14.0), name="robot3")
    assert interferences([still, near]) == 3  # at 0, 10 and 20 s of 25 s
    assert interferences([still, far]) == 0


def test_approach_and_retreat_is_a_meeting_turned_back(border: Border) -> None:
    approach = np.concatenate([np.arange(0.0, 3.0, 0.035), np.arange(3.0, 0.0, -0.035)])
    a = run_along(border, 10.0 + approach, action=Action.PATROL_COUNTER_CLOCKWISE, direction=-1)
    b = run_along(
        border, 17.6 - approach, name="robot2", action=Action.PATROL_CLOCKWISE, direction=1
    )
    (meeting,) = meetings(border, [a, b])
    assert meeting.outcome == "turned back"
    assert meeting.closest_m == pytest.approx(closest_approach([a, b]))
    assert meeting.closest_m == pytest.approx(1.6, abs=0.1)


def test_one_that_follows_and_turns_has_not_passed(border: Border) -> None:
    ahead = np.arange(0.0, 6.0, 0.035)
    behind = np.concatenate([np.arange(0.0, 3.0, 0.07), np.arange(3.0, 0.0, -0.035)])[: len(ahead)]
    a = run_along(border, 13.0 + ahead[: len(behind)])
    b = run_along(border, 10.0 + behind, name="robot2", action=Action.PATROL_CLOCKWISE)
    (meeting,) = meetings(border, [a, b])
    assert meeting.outcome == "one turned back"


def test_robots_that_change_places_pass_each_other(border: Border) -> None:
    s = np.arange(0.0, 8.0, 0.035)
    a = run_along(border, s, action=Action.PATROL_CLOCKWISE)
    b = run_along(border, 8.0 - s, name="robot2")
    (meeting,) = meetings(border, [a, b])
    assert meeting.outcome == "passed by"


@pytest.mark.parametrize(("steps", "outcome"), [(5, "cut off"), (250, "still together")])
def test_meeting_at_the_end_of_the_run_is_cut_off_unless_it_lasted(
    border: Border, steps: int, outcome: str
) -> None:
    a = run_along(border, np.full(steps, 10.0), action=Action.AVOID_TEAMMATE)
    b = run_along(border, np.full(steps, 12.0), name="robot2")
    (meeting,) = meetings(border, [a, b])
    assert meeting.outcome == outcome


def test_figures_have_the_keys_scripts_rely_on(border: Border) -> None:
    figures = bench_figures(border, [run_along(border, np.full(20, 3.0))], contacts=0, speed=0.35)
    assert set(figures) >= {
        "contacts",
        "closest_m",
        "border_distance_m",
        "reach_s",
        "meetings",
        "idleness_s",
        "unpredictability",
        "intruder_seen",
        "intruder_bound",
        "action_share",
        "longest_avoid_s",
    }
    assert set(figures["border_distance_m"]) == {"median", "p95", "p99", "max"}


def test_settled_distance_leaves_out_the_approach(border: Border) -> None:
    s = np.linspace(3.0, 6.0, 40)
    run = run_along(border, s)
    aside = np.where(np.arange(40) < 10, 0.09, 0.01)
    run.position[:, 1] += aside  # the border is straight along x there
    figures = bench_figures(border, [run], contacts=0, speed=0.35)
    assert figures["border_distance_m"]["max"] == pytest.approx(0.09)
    assert figures["settled"]["border_distance_m"]["max"] == pytest.approx(0.01)
