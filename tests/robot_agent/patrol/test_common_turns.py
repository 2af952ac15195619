"""Common turns of a team, by the ideal bench: in step, late, wrong clocks, deaths."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from maps.map_folder import load_map_folder
from maps.pose import Pose
from robot_agent.config import AgentConfig, find_map
from robot_agent.patrol.common_clock import CommonClock, common_clock
from robot_agent.patrol.patrol import Patrol
from robot_agent.patrol.settings import PatrolSettings
from robot_agent.patrol.turn_log import TurnCause, TurnLog
from tools.batch.batch import Batch
from tools.bench.bench_fault import parse_fault
from tools.bench.ideal_fleet import IdealFleet, secret_of

COMMON = (
    *("standoff", "hold_at_end", "blockage", "closing_in"),
    *("common_turns", "even_gaps", "around_walls", "dwell"),
)
EVEN = tuple(name for name in COMMON if name != "common_turns")
FOLDER = load_map_folder(find_map("paper_lab", Path.cwd()))


def config(**patrol: object) -> AgentConfig:
    one = AgentConfig()
    settings = {"modifiers": COMMON, "common_secret": "x", "team_size": 3} | patrol
    return msgspec.structs.replace(one, patrol=msgspec.structs.replace(one.patrol, **settings))


def spaced() -> list[Pose]:
    """Return three robots on the border, evenly spaced, that look clockwise."""
    points = [FOLDER.border.at(FOLDER.border.length * number / 3) for number in range(3)]
    return [Pose(x, y, float(np.arctan2(ty, tx))) for x, y, tx, ty, _ in points]


def common_turns(log: TurnLog) -> list[float]:
    """Return the times of a robot's common turns."""
    both = [turn.t for way in (1, -1) for turn in log.latest_first(TurnCause.COMMON, way)]
    return sorted(both)


def test_robots_in_step_turn_at_the_same_moments_and_stay_evenly_spaced():
    fleet = IdealFleet(FOLDER, 3, 2, config(reversal_probability=0.7), starts=spaced())
    turns: list[set[float]] = [set(), set(), set()]
    while fleet.t < 1400.0:
        fleet.step()
        for own, robot in zip(turns, fleet.robots, strict=True):
            if robot.decision.turn is TurnCause.COMMON and fleet.t > 1201.0:
                own.add(robot.decision.t)
    assert len(turns[0]) >= 3
    assert turns[0] == turns[1] == turns[2]
    places = sorted(robot.decision.abscissa for robot in fleet.robots)
    assert np.diff(places) == pytest.approx([17.0, 17.0], abs=1.5)
    assert fleet.world.contacts == 0


@pytest.mark.long
def test_late_clocks_deaths_and_wrong_counts_end_common_turns_without_a_contact():
    late = CommonClock(-30.0)
    right = CommonClock(0.0)
    death = [parse_fault("robot2:dead@1300")]
    runs = {"right": [], "a second late": [], "half a minute late": [], "death": death}
    clocks = [right] * 3 + [CommonClock(-0.8), right, right] + [late, right, right] + [right] * 3
    batch = Batch(
        FOLDER,
        3,
        [2] * 4,
        config(reversal_probability=0.7),
        starts=[spaced()] * 4,
        faults=list(runs.values()),
        clocks=clocks,
    )
    while batch.t < 1800.0:
        batch.step()
    count = [len(common_turns(batch.patrols.turns[robot])) for robot in range(12)]
    assert min(count[:6]) >= 6
    assert min(count[6:9]) < min(count[:6])
    last = max(max(common_turns(batch.patrols.turns[robot]), default=0.0) for robot in (9, 11))
    assert last < 1500.0
    assert [batch.bodies.contacts(run) for run in range(4)] == [0] * 4


class FastPatrol:
    """A patrol on a computer whose clock gains so many s a day."""

    def __init__(self, patrol, gain: float):
        self._patrol = patrol
        self._rate = 1.0 + gain / 86400.0

    def step(self, t: float, *seen, **held):
        return self._patrol.step(t * self._rate, *seen, **held)


@pytest.mark.parametrize(("drift", "together"), [(500.0, True), (0.0, False)])
def test_a_clock_that_gains_is_right_with_its_drift_known(drift, together):
    """One clock gains 7 s until 1200 s; the team turns together from 600 or 1200 s on."""
    settings = config(reversal_probability=0.7)
    fleet = IdealFleet(FOLDER, 3, 2, settings, starts=spaced())
    one = fleet.robots[0]
    secret = secret_of(settings, seed=2)
    own = Patrol(
        msgspec.structs.replace(settings.patrol, common_secret=secret),
        FOLDER.border,
        np.random.default_rng(2000),
        clock=CommonClock(0.0, drift),
    )
    one.patrol = FastPatrol(own, gain=500.0)
    turns: list[set[float]] = [set(), set(), set()]
    while fleet.t < 1402.0:  # half a tick after the last
        fleet.step()
        for times, robot in zip(turns, fleet.robots, strict=True):
            if robot.decision.turn is TurnCause.COMMON and fleet.t > 1201.0:
                times.add(fleet.t)
    assert len(turns[1]) >= 3
    assert turns[1] == turns[2]
    assert same_moments(turns[0], turns[1]) is together


def same_moments(some: set[float], others: set[float]) -> bool:
    """Return whether every moment of one set is within a second of one of the other, both ways."""
    apart = np.abs(np.subtract.outer(sorted(some), sorted(others)))
    return bool(apart.size) and bool(
        (apart <= 1.0).any(axis=0).all() and (apart <= 1.0).any(1).all()
    )


def test_without_secret_or_clock_there_are_no_common_turns():
    fleet = IdealFleet(FOLDER, 3, 1, config(common_secret=""), starts=spaced())
    other = IdealFleet(FOLDER, 3, 1, config(modifiers=EVEN, common_secret=""), starts=spaced())
    for _ in range(600):
        fleet.step()
        other.step()
    assert [robot.body.pose for robot in fleet.robots] == [
        robot.body.pose for robot in other.robots
    ]


def test_a_clock_that_was_not_set_is_none():
    assert common_clock(1_000_000_000, 0.0) is None
    assert common_clock(0, 0.0) == CommonClock(0.0)
    set_clock = common_clock(1_800_000_000_000_000_000, 8.64)
    assert set_clock is not None
    assert set_clock.at(1e4) == pytest.approx(1_800_000_000.0 + 1e4 - 1.0)


def test_common_turns_need_even_gaps_after_them():
    with pytest.raises(ValueError, match="needs even_gaps"):
        PatrolSettings(modifiers=("common_turns", "dwell"))
