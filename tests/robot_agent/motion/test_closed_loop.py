"""Patrol and heading loop driving unicycles: exact poses, 10 Hz, commands one step late."""

import math
from dataclasses import dataclass

import numpy as np
import pytest

from maps.border import Border
from maps.border_primitives import Arc, Segment
from maps.pose import Pose, wrap_angle
from robot_agent.motion.heading_loop import HeadingLoop
from robot_agent.patrol.actions import PATROLLING, Action
from robot_agent.patrol.patrol import Patrol, PatrolDecision
from robot_agent.patrol.settings import PAPER_STRATEGY, PatrolSettings

DT = 0.1
VISIBILITY = 2.5  # m
CONTACT = 0.58  # m between centres of two circumscribed circles of the paper's robots


def rounded_rectangle(first: int = 0) -> Border:
    """17 x 10 m, corner radius 1.75 m, 51.0 m long; s = 0 at the start of its first-th piece."""
    w, h, r, quarter = 17.0, 10.0, 1.75, -math.pi / 2
    pieces = [
        Segment((0.0, r), (0.0, h - r)),
        Arc((r, h - r), r, math.pi, quarter),
        Segment((r, h), (w - r, h)),
        Arc((w - r, h - r), r, math.pi / 2, quarter),
        Segment((w, h - r), (w, r)),
        Arc((w - r, r), r, 0.0, quarter),
        Segment((w - r, 0.0), (r, 0.0)),
        Arc((r, r), r, -math.pi / 2, quarter),
    ]
    return Border(pieces[first:] + pieces[:first], closed=True)


RECTANGLE = rounded_rectangle()
LINE = Border([Segment((0.0, 0.0), (12.0, 0.0))], closed=False)


AWAY = (Action.PATROL_COUNTER_CLOCKWISE, Action.PATROL_CLOCKWISE)  # from the other, in a meeting


SUPERVISORS = ("fuzzy", "automaton")


@dataclass
class Sample:
    decision: PatrolDecision
    pose: Pose


class Robot:
    """A unicycle with 0.3 m/s2 and 2 rad/s2; can be stopped for good."""

    def __init__(self, border: Border, pose: Pose, seed: int, settings: PatrolSettings) -> None:
        self.patrol = Patrol(settings, border, np.random.default_rng(seed))
        self.loop = HeadingLoop()
        self.pose = pose
        self.stopped = False
        self.samples: list[Sample] = []
        self._v = self._w = 0.0
        self._pending = (0.0, 0.0)

    def decide(self, t: float, teammate: tuple[float, float] | None) -> tuple[float, float]:
        decision = self.patrol.step(t, self.pose, teammate)
        self.samples.append(Sample(decision, self.pose))
        return self.loop.command(t, decision.velocity, self.pose.theta, decision.curvature)

    def move(self, command: tuple[float, float]) -> None:
        v, w = (0.0, 0.0) if self.stopped else self._pending
        self._pending = command
        for _ in range(2):
            h = DT / 2
            self._v += min(max(v - self._v, -0.3 * h), 0.3 * h)
            self._w += min(max(w - self._w, -2.0 * h), 2.0 * h)
            x, y, theta = self.pose
            middle = theta + self._w * h / 2
            self.pose = Pose(
                x + self._v * h * math.cos(middle),
                y + self._v * h * math.sin(middle),
                wrap_angle(theta + self._w * h),
            )


def drive(border, poses, duration, *, seed=0, probability=0.0, stopped=(), supervisor="fuzzy"):
    """Let robots patrol; returns them with their samples."""
    settings = PatrolSettings(
        reversal_probability=probability, supervisor=supervisor, modifiers=PAPER_STRATEGY
    )
    robots = [Robot(border, p, 100 * seed + i, settings) for i, p in enumerate(poses)]
    for i in stopped:
        robots[i].stopped = True
    return run(robots, duration)


def run(robots, duration):
    """Let made robots patrol together; returns them."""
    for k in range(int(duration / DT)):
        places = [robot.pose[:2] for robot in robots]
        commands = [r.decide(DT * k, nearest(places, i)) for i, r in enumerate(robots)]
        for robot, command in zip(robots, commands, strict=True):
            robot.move(command)
    return robots


def nearest(places, i):
    others = [(math.dist(places[i], p), p) for j, p in enumerate(places) if j != i]
    distance, place = min(others, default=(math.inf, None))
    return place if distance <= VISIBILITY else None


def on(border, s, direction=1):
    x, y, tx, ty, _ = border.at(s)
    return Pose(x, y, math.atan2(direction * ty, direction * tx))


def closest_approach(robots):
    tracks = np.array([[s.pose[:2] for s in r.samples] for r in robots])
    pairs = [(i, j) for i in range(len(robots)) for j in range(i)]
    return min(np.linalg.norm(tracks[i] - tracks[j], axis=1).min() for i, j in pairs)


def distances(robots, arrival=0.10):
    """Distances from the border while patrolling, from the first arrival (within so many m) on."""
    found = []
    for robot in robots:
        d = np.array([s.decision.distance_from_border for s in robot.samples])
        patrolling = np.array([s.decision.action in PATROLLING for s in robot.samples])
        arrived = np.cumsum(d < arrival) > 0
        found.append(d[arrived & patrolling])
    return np.concatenate(found)


@pytest.mark.parametrize("direction", [1, -1])
def test_one_lap_stays_on_the_border(direction):
    robots = drive(RECTANGLE, [on(RECTANGLE, 3.0, direction)], 152.0)
    d = distances(robots)
    assert np.percentile(d, 95) < 0.01
    assert d.max() < 0.02
    travelled = np.unwrap([s.decision.abscissa for s in robots[0].samples], period=RECTANGLE.length)
    assert abs(travelled[-1] - travelled[0]) > RECTANGLE.length
    assert {s.decision.direction for s in robots[0].samples} == {direction}


@pytest.mark.parametrize("turn", [1, -1])
def test_tightest_border_accepted_is_followed(turn):
    """Of the 0.1 m of the paper the tightest corner takes less than half, a tighter one all."""
    deviations = []
    for radius in (0.5, 0.3):
        corner = Arc((4.0, turn * radius), radius, -turn * math.pi / 2, turn * math.pi)
        back = Segment(corner.end, (0.0, corner.end[1]))
        border = Border([Segment((0.0, 0.0), (4.0, 0.0)), corner, back], closed=False)
        settings = PatrolSettings(
            reversal_probability=0.0, turning_radius=radius, modifiers=PAPER_STRATEGY
        )
        robots = run([Robot(border, on(border, 1.0), 0, settings)], 20.0)
        assert robots[0].samples[-1].decision.abscissa > 4.0 + math.pi * radius + 1.0
        deviations.append(distances(robots).max())
    assert deviations[0] < 0.05
    assert deviations[1] > 0.1


def test_reversals_do_not_leave_the_border():
    """Braking along the border before the turn, and a turn that can be braked: no excursions."""
    robots = drive(RECTANGLE, [on(RECTANGLE, 3.0)], 300.0, probability=1.0)
    d = distances(robots)
    directions = [s.decision.direction for s in robots[0].samples]
    assert np.count_nonzero(np.diff(directions)) >= 10
    assert d.max() < 0.03


@pytest.mark.parametrize("supervisor", SUPERVISORS)
def test_reaches_the_border_from_far(supervisor):
    robots = drive(RECTANGLE, [Pose(8.5, 5.0, 0.3)], 60.0, supervisor=supervisor)
    d = np.array([s.decision.distance_from_border for s in robots[0].samples])
    assert robots[0].samples[0].decision.action is Action.REACH_FRONTIER
    assert d[200:].max() < 1.5
    assert d[-1] < 0.01


@pytest.mark.parametrize("supervisor", SUPERVISORS)
@pytest.mark.parametrize("meeting", [0.0, 13.0, 25.5, 47.0])  # 0: across the seam
def test_two_robots_meeting_head_on(meeting, supervisor):
    """They approach from 4 m; one turns clockwise, the other counter-clockwise."""
    poses = [on(RECTANGLE, meeting - 2.0, 1), on(RECTANGLE, meeting + 2.0, -1)]
    robots = drive(RECTANGLE, poses, 20.0, supervisor=supervisor)
    changes = []
    for robot, away in zip(robots, AWAY, strict=True):
        actions = [s.decision.action for s in robot.samples]
        assert set(actions) == {Action.KEEP_GOING, away}
        changes.append(actions.index(away))
        assert actions[-1] is Action.KEEP_GOING
    assert abs(changes[0] - changes[1]) <= 2
    assert [r.samples[-1].decision.direction for r in robots] == [-1, 1]
    assert closest_approach(robots) > 1.25
    assert distances(robots).max() < 0.03


def test_seam_does_not_change_the_path():
    """The same meeting with s = 0 elsewhere gives the same run."""
    runs = []
    for first in (0, 2, 3):  # first piece 3: the seam is under the left robot
        border = rounded_rectangle(first)
        s = border.project(15.25, 10.0).abscissa
        robots = drive(border, [on(border, s - 2.0, 1), on(border, s + 2.0, -1)], 15.0)
        runs.append(np.array([[x.pose[:2] for x in r.samples] for r in robots]))
    assert runs[1] == pytest.approx(runs[0], abs=1e-6)
    assert runs[2] == pytest.approx(runs[0], abs=1e-6)


@pytest.mark.parametrize("first", [1, 3, 4, 6])
def test_seam_does_not_change_the_paths_of_a_team(first):
    """Three robots, random reversals, meetings everywhere: the same run wherever s = 0 lies."""
    team = [on(RECTANGLE, 1.0), on(RECTANGLE, 20.0, -1), on(RECTANGLE, 37.0)]
    one, other = (
        drive(border, team, 120.0, seed=3, probability=0.5)
        for border in (RECTANGLE, rounded_rectangle(first))
    )
    for robot, twin in zip(one, other, strict=True):
        actions = [s.decision.action for s in robot.samples]
        assert actions == [s.decision.action for s in twin.samples]
        assert track(twin) == pytest.approx(track(robot), abs=1e-6)
    met = {s.decision.action for robot in one for s in robot.samples}
    assert set(AWAY) <= met


def track(robot):
    """Places and headings (samples, 4): x, y, cosine, sine, which do not wrap."""
    x, y, theta = np.array([s.pose for s in robot.samples]).T
    return np.column_stack((x, y, np.cos(theta), np.sin(theta)))


def test_seam_within_a_segment_does_not_change_the_path():
    """s = 0 in the middle of a straight, one robot standing on it as two meet there."""
    pieces = rounded_rectangle().primitives
    top = pieces[2]
    middle = (8.5, 10.0)
    split = [Segment(middle, top.end), *pieces[3:], *pieces[:2], Segment(top.start, middle)]
    border = Border(split, closed=True)
    assert border.at(0.0)[:2] == pytest.approx(middle)
    runs = []
    for line in (RECTANGLE, border):
        s = line.project(*middle).abscissa
        robots = drive(line, [on(line, s - 2.3, 1), on(line, s + 2.3, -1)], 20.0)
        runs.append(np.array([track(r) for r in robots]))
    assert runs[1] == pytest.approx(runs[0], abs=1e-6)


def test_avoid_teammate_separates_two_that_start_too_near():
    middle = (8.5, 10.0)
    s = RECTANGLE.project(*middle).abscissa
    robots = drive(RECTANGLE, [on(RECTANGLE, s - 0.4, 1), on(RECTANGLE, s + 0.4, -1)], 20.0)
    assert {r.samples[0].decision.action for r in robots} == {Action.AVOID_TEAMMATE}
    apart = math.dist(robots[0].pose[:2], robots[1].pose[:2])
    assert closest_approach(robots) > CONTACT
    assert apart > 4.0
    assert {r.samples[-1].decision.action for r in robots} == {Action.KEEP_GOING}


@pytest.mark.parametrize("supervisor", SUPERVISORS)
@pytest.mark.parametrize("seed", [1, 2])
def test_three_robots_patrol_without_contact(seed, supervisor):
    rng = np.random.default_rng(seed)
    poses = [
        Pose(float(rng.uniform(1, 16)), float(y), float(rng.uniform(-3, 3))) for y in (2, 5, 8)
    ]
    robots = drive(RECTANGLE, poses, 600.0, seed=seed, probability=0.25, supervisor=supervisor)
    assert closest_approach(robots) > 1.1
    d = distances(robots)
    assert np.percentile(d, 99) < 0.03
    assert d.max() < 0.10
    assert distances(robots, arrival=0.01).max() < 0.04
    for robot in robots:
        assert longest_avoid(robot) < 30.0


def longest_avoid(robot):
    longest = current = 0
    for sample in robot.samples:
        current = current + 1 if sample.decision.action is Action.AVOID_TEAMMATE else 0
        longest = max(longest, current)
    return longest * DT


@pytest.mark.parametrize("supervisor", SUPERVISORS)
@pytest.mark.parametrize("gap", [1.2, 1.5, 1.8])
def test_no_deadlock_where_robots_avoid_off_the_border(gap, supervisor):
    """On one line square to the border N_ta v_rf is zero; d_s beyond the avoiding zone frees them.

    Both stand farther than 1.5 m from the border, the outer one between the other and the border.
    """
    poses = [Pose(8.5, 10.0 - 3.2, 1.0), Pose(8.5, 10.0 - 3.2 - gap, 1.0)]
    robots = drive(RECTANGLE, poses, 90.0, supervisor=supervisor)
    for robot in robots:
        assert longest_avoid(robot) < 30.0
        assert robot.samples[-1].decision.action is Action.KEEP_GOING
    assert closest_approach(robots) > CONTACT


def test_stopped_robot_is_turned_back_from():
    """A wreck on the border turns its teammate 1.9 m before it, from both sides."""
    s = RECTANGLE.project(8.5, 10.0).abscissa
    robots = drive(RECTANGLE, [on(RECTANGLE, s), on(RECTANGLE, s - 4.0)], 160.0, stopped=(0,))
    assert closest_approach(robots) > 1.1
    assert len({x.decision.direction for x in robots[1].samples}) == 2


@pytest.mark.parametrize("supervisor", SUPERVISORS)
def test_open_border_is_driven_from_end_to_end(supervisor):
    robots = drive(LINE, [on(LINE, 5.0)], 120.0, supervisor=supervisor)
    s = np.array([x.decision.abscissa for x in robots[0].samples])
    assert s.min() < 0.6
    assert s.max() > LINE.length - 0.6
    assert s.min() > 0.0
    assert s.max() < LINE.length
    assert np.count_nonzero(np.diff([x.decision.direction for x in robots[0].samples])) >= 3
    assert distances(robots).max() < 0.02


BENT = Border(
    [
        Segment((0.0, 0.0), (8.0, 0.0)),
        Arc((8.0, 1.25), 1.25, -math.pi / 2, math.pi / 2),
        Segment((9.25, 1.25), (9.25, 6.0)),
        Arc((10.5, 6.0), 1.25, math.pi, -math.pi / 2),
        Segment((10.5, 7.25), (18.0, 7.25)),
    ],
    closed=False,
)


@pytest.mark.parametrize("supervisor", SUPERVISORS)
def test_every_metre_of_an_open_border_is_patrolled(supervisor):
    """Three robots and random reversals; what is left at the ends is half a robot more or less."""
    team = [on(BENT, 3.0), on(BENT, 11.0, -1), on(BENT, 19.0)]
    robots = drive(BENT, team, 600.0, seed=2, probability=0.25, supervisor=supervisor)
    s = np.sort([x.decision.abscissa for r in robots for x in r.samples])
    assert s[0] < 0.6
    assert s[-1] > BENT.length - 0.6
    assert np.diff(s).max() < 0.05  # between the ends no gap
    assert closest_approach(robots) > 1.1
    assert all(longest_avoid(robot) < 30.0 for robot in robots)


@pytest.mark.parametrize("supervisor", SUPERVISORS)
def test_caught_between_end_and_teammate_holds_until_it_leaves(supervisor):
    robots = drive(LINE, [on(LINE, 0.5, -1), on(LINE, 4.0, -1)], 60.0, supervisor=supervisor)
    assert closest_approach(robots) > 1.1
    assert robots[0].samples[-1].decision.abscissa > 1.0  # came out again
    assert not robots[0].samples[-1].decision.holding
    directions = np.diff([x.decision.direction for x in robots[0].samples])
    assert np.count_nonzero(directions) <= 4  # it does not shuffle to and fro


def test_robot_caught_by_a_wreck_leaves_the_end_after_a_while():
    robots = drive(LINE, [on(LINE, 0.3, -1), on(LINE, 1.9)], 30.0, stopped=(1,))
    x = np.array([sample.pose.x for sample in robots[0].samples])
    assert np.ptp(x[40:110]) < 0.05
    assert 0.3 < np.ptp(x) < 0.8
    assert closest_approach(robots) > 1.0
