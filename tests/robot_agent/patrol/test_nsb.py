"""Null-space composition: priority is never broken, whatever the tasks and the speed limit."""

import math
from itertools import permutations
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from maps.approach_field import Approach
from maps.map_folder import load_map_folder
from robot_agent.config import find_map
from robot_agent.patrol.behaviors import (
    Task,
    patrol_clockwise,
    patrol_counter_clockwise,
    patrol_onward,
    reach_around_walls,
    reach_frontier,
    teammate_avoidance,
)
from robot_agent.patrol.nsb import compose

coordinate = st.floats(-2.0, 2.0, allow_subnormal=False).map(lambda x: round(x, 6))


@st.composite
def task_lists(draw):
    """Up to 4 tasks of 1 or 2 rows in 2 to 4 dimensions, each within the span of its Jacobian."""
    n = draw(st.integers(2, 4))
    tasks = []
    for _ in range(draw(st.integers(1, 4))):
        rows = draw(st.integers(1, 2))
        jacobian = np.array(
            [[draw(coordinate) for _ in range(n)] for _ in range(rows)], dtype=float
        )
        error = np.array([draw(coordinate) for _ in range(rows)])
        tasks.append(Task(np.linalg.pinv(jacobian, rcond=1e-6) @ error, jacobian))
    return tasks


@settings(max_examples=200)
@given(task_lists(), st.one_of(st.just(np.inf), st.floats(0.05, 3.0)))
def test_task_never_changes_velocities_of_higher_priority(tasks, limit):
    for count in range(1, len(tasks)):
        alone, more = compose(tasks[:count], limit), compose(tasks[: count + 1], limit)
        for task in tasks[:count]:
            scale = max(1.0, float(np.abs(task.jacobian).max()))
            assert task.jacobian @ more == pytest.approx(task.jacobian @ alone, abs=1e-6 * scale)


@settings(max_examples=200)
@given(task_lists(), st.floats(0.05, 3.0))
def test_speed_never_exceeds_the_limit(tasks, limit):
    assert np.linalg.norm(compose(tasks, limit)) <= limit * (1 + 1e-9)


@settings(max_examples=100)
@given(task_lists())
def test_equals_the_formula_with_pseudo_inverses(tasks):
    """v = v1 + N1 v2 + N12 v3 ..., N of the stacked Jacobians."""
    n = len(tasks[0].velocity)
    expected, stacked = np.zeros(n), np.zeros((0, n))
    for task in tasks:
        null_space = np.eye(n) - np.linalg.pinv(stacked, rcond=1e-7) @ stacked
        expected = expected + null_space @ task.velocity
        stacked = np.vstack([stacked, task.jacobian])
        singular = np.linalg.svd(stacked, compute_uv=False)
        if np.any((singular > 1e-12) & (singular < 1e-3)):
            return  # rank in doubt, both answers are right
    assert compose(tasks) == pytest.approx(expected, abs=1e-5 * (1 + np.abs(expected).max()))


def test_conflicting_part_of_the_second_task_vanishes():
    first = Task(np.array([0.0, -0.2]), np.array([[0.0, 1.0]]))
    second = Task(np.array([0.3, 0.9]), np.array([[0.6, 0.8]]))
    assert compose([first, second]) == pytest.approx([0.3, -0.2])


def test_saturation_keeps_the_first_and_scales_the_rest():
    first = Task(np.array([0.0, -0.4]), np.array([[0.0, 1.0]]))
    second = Task(np.array([0.6, 0.0]), np.array([[1.0, 0.0]]))
    assert compose([first, second], 0.5) == pytest.approx([0.3, -0.4])
    assert compose([first, second], 0.3) == pytest.approx([0.0, -0.3])


def test_third_task_gets_the_remaining_null_space():
    x, y, z = np.eye(3)
    tasks = [Task(0.1 * x, x[None]), Task(y + x, y[None]), Task(x + y + z, z[None])]
    assert compose(tasks) == pytest.approx([0.1, 1.0, 1.0])


BORDERS = [
    load_map_folder(find_map("paper_lab", Path.cwd()), name).border for name in ("border", "open")
]


def behavior(name, border, position, teammate, direction):
    """Return the task of an elementary behavior of the paper, at its default gains."""
    foot = border.project(*position)
    ends = not border.closed and foot.abscissa in (0.0, border.length)
    match name:
        case "reach_frontier":
            return reach_frontier(position, foot, gain=0.3, speed_limit=0.5, beyond_end=ends)
        case "reach_around_walls":
            way = Approach(3.0, (math.cos(direction), math.sin(direction)))
            return reach_around_walls(way, gain=0.3, speed_limit=0.5)
        case "patrol_clockwise":
            return patrol_clockwise(foot, speed=0.35)
        case "patrol_counter_clockwise":
            return patrol_counter_clockwise(foot, speed=0.35)
        case "patrol_onward":
            return patrol_onward(foot, 1 if direction > 0.0 else -1, speed=0.35)
        case _:
            return teammate_avoidance(
                position,
                teammate,
                gain=0.3,
                safety_distance=2.4,
                speed_limit=0.3,
                fallback=foot.normal,
            )


BEHAVIORS = (
    "reach_frontier",
    "reach_around_walls",
    "patrol_clockwise",
    "patrol_counter_clockwise",
    "patrol_onward",
    "teammate_avoidance",
)
place = st.tuples(st.floats(-2.0, 18.0), st.floats(-2.0, 18.0))


@pytest.mark.parametrize(("first", "second"), list(permutations(BEHAVIORS, 2)))
@settings(max_examples=40)
@given(
    border=st.sampled_from(BORDERS),
    position=place,
    teammate=place,
    direction=st.floats(-math.pi, math.pi),
    limit=st.sampled_from([0.2, 0.5, math.inf]),
)
def test_no_behavior_changes_one_of_higher_priority(
    first, second, border, position, teammate, direction, limit
):
    primary, secondary = (
        behavior(name, border, position, teammate, direction) for name in (first, second)
    )
    alone, both = compose([primary], limit), compose([primary, secondary], limit)
    (claimed,) = primary.jacobian
    assert np.dot(claimed, both) == pytest.approx(np.dot(claimed, alone), abs=1e-9)
    assert math.hypot(*both) <= limit * (1 + 1e-9)
    # The free component is that of the second task, within the rest of the limit.
    free = (-claimed[1], claimed[0])
    wanted = np.dot(free, alone) + np.dot(free, secondary.velocity)
    # Exactly at the limit nothing is left, apart from rounding.
    if math.hypot(np.dot(claimed, alone), wanted) < limit * (1.0 - 1e-9):
        assert np.dot(free, both) == pytest.approx(wanted, abs=1e-9)
