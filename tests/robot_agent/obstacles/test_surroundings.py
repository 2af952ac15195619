"""Obstacle points around the robot from all sources."""

import math

import numpy as np
import pytest

from drivers.lms200.measurement import TURN
from drivers.p2os.model import load_model
from drivers.scan import Scan
from maps.occupancy_map import FREE, OCCUPIED, OccupancyMap
from maps.pose import Pose
from robot_agent.config import AgentConfig
from robot_agent.motion.gate_settings import gate_limits
from robot_agent.motion.obstacle_points import ObstacleSource
from robot_agent.obstacles.surroundings import Surroundings
from robot_agent.perception.identity import Kind, Probabilities
from robot_agent.perception.scan_points import ScanProjector
from robot_agent.perception.track import Track
from robot_agent.perception.unexplained import UnexplainedPoints
from robot_agent.pose.odometry_history import OdometryHistory
from tests.robot_agent.obstacles.sonar_report import sonar_report

POST = (0.0, 0.3)
"""(x, y) in the map: left of a robot at the origin, just behind what its laser sees."""


@pytest.fixture
def surroundings() -> Surroundings:
    return surroundings_of("p2dx")


def surroundings_of(name: str) -> Surroundings:
    """Return those of a robot of a model in a room with a post."""
    cells = np.full((80, 80), FREE, dtype=np.uint8)
    cells[46, 40] = OCCUPIED  # its near side is at y = 0.3 m
    occupancy = OccupancyMap(cells, 0.05, Pose(-2.025, -2.0, 0.0))
    config = AgentConfig()
    unexplained = UnexplainedPoints(occupancy, config.perception.detection_range)
    model = load_model(name)
    projector = ScanProjector(Pose(*model.laser_mount))
    return Surroundings(projector, gate_limits(config.gate, model), model, occupancy, unexplained)


def looked(surroundings: Surroundings, heading: float, far: float = 3.0) -> None:
    """Process a scan of walls far away, at the origin with a heading; far: m, inf: no returns."""
    scan = Scan(
        t=1.0,
        angle_min=-math.pi / 2,
        angle_increment=math.radians(1.0),
        ranges=np.full(181, far),
        status=0x10,
        turns=1,
        turn_time=TURN,
        specials=np.zeros(181, dtype=np.uint8),
        flags=np.zeros(181, dtype=np.uint8),
        reflectors=None,
    )
    surroundings.on_scan(scan, Pose(0.0, 0.0, heading), OdometryHistory())


def around(surroundings: Surroundings, heading: float) -> np.ndarray:
    pose = Pose(0.0, 0.0, heading)
    return surroundings.around(1.0, pose, pose, []).points


def test_wall_beside_a_turning_robot_is_unseen_until_the_next_scan(
    surroundings: Surroundings,
) -> None:
    looked(surroundings, heading=0.0)
    assert around(surroundings, 0.0) == pytest.approx(np.array([POST]), abs=0.03)
    # Turned left, the post is in the laser's view, but there is no scan of it yet.
    turned = around(surroundings, 0.4)
    assert np.hypot(*turned.T) == pytest.approx(0.29, abs=0.01)
    assert turned[0, 0] > 0.1


def test_map_walls_in_view_of_the_latest_scan_are_left_out(surroundings: Surroundings) -> None:
    looked(surroundings, heading=0.4)
    assert not len(around(surroundings, 0.4))
    assert not len(around(surroundings, 0.0))  # turned back: the scan has shown it to be free


def test_map_walls_count_where_the_beams_do_not_return(surroundings: Surroundings) -> None:
    looked(surroundings, heading=0.4, far=np.inf)  # as before a dark or a shiny surface
    assert len(around(surroundings, 0.4)) == 1


def located(surroundings: Surroundings, heading: float, localized: bool = True) -> None:
    """Take in that the latest scan was measured at the origin with a heading."""
    pose = Pose(0.0, 0.0, heading)
    surroundings.on_located_scan(1.0, pose, pose if localized else None, np.empty((0, 2)))


def test_a_mapped_wall_that_was_seen_through_is_gone_also_out_of_view(
    surroundings: Surroundings,
) -> None:
    for _ in range(3):
        looked(surroundings, heading=1.0)
        located(surroundings, heading=1.0)
    looked(surroundings, heading=-0.5)
    located(surroundings, heading=-0.5)
    assert not len(around(surroundings, -0.5))
    located(surroundings, heading=-0.5, localized=False)
    assert len(around(surroundings, -0.5)) == 1, "without a pose nothing is known of it"


def test_a_mapped_wall_that_sends_no_beam_back_is_not_gone(surroundings: Surroundings) -> None:
    for heading in (1.0, 1.0, 1.0, -0.5):
        looked(surroundings, heading, far=np.inf)
        located(surroundings, heading)
    assert len(around(surroundings, -0.5)) == 1


BEFORE_THE_POST = Pose(-0.5, 0.05, 0.0)
"""map_from_base: the post stands ahead on the left, in the cone of the transducer at 30 degrees."""


def sonar_heard(surroundings: Surroundings, localized: Pose | None) -> int:
    """Return how many front echoes count after three that the post sends."""
    origin = Pose(0.0, 0.0, 0.0)
    for t in (1.0, 1.3, 1.6):
        state = sonar_report(t, (2, 0.39))
        surroundings.on_sonar(state, origin, localized)
    return len(surroundings.echoes(1.6, origin))


def test_echo_of_a_mapped_wall_that_sends_no_beam_back_is_left_to_the_map(
    surroundings: Surroundings,
) -> None:
    looked(surroundings, heading=0.0, far=np.inf)
    assert sonar_heard(surroundings, BEFORE_THE_POST) == 0


def test_echo_without_a_pose_counts(surroundings: Surroundings) -> None:
    looked(surroundings, heading=0.0, far=np.inf)
    assert sonar_heard(surroundings, None) > 0


def test_echo_where_the_scan_shows_that_the_mapped_wall_is_gone_counts(
    surroundings: Surroundings,
) -> None:
    looked(surroundings, heading=0.0)
    assert sonar_heard(surroundings, BEFORE_THE_POST) > 0


def test_without_a_scan_map_walls_of_all_sides_are_returned(surroundings: Surroundings) -> None:
    assert len(around(surroundings, 0.4)) == 1


@pytest.mark.parametrize(
    ("model", "kind", "is_like", "has_room"),
    [
        pytest.param("p2dx", Kind.TEAMMATE, {"robot_sized"}, True, id="teammate"),
        pytest.param("p2dx", Kind.STRANGER, {"robot_sized", "moving"}, True, id="moves like one"),
        pytest.param("p2dx", Kind.STRANGER, {"robot_sized"}, False, id="box"),
        pytest.param("p2dx", Kind.UNKNOWN, {"robot_sized"}, False, id="short robot or box"),
        pytest.param("p2dx", Kind.UNKNOWN, {"robot_sized", "fast"}, True, id="seems to move"),
        pytest.param("p2dx", Kind.UNKNOWN, {"fast"}, False, id="too small and seems to move"),
        pytest.param(
            "p2dx", Kind.STRANGER, {"robot_sized", "fast", "by_color"}, False, id="moves, no band"
        ),
        pytest.param("powerbot", Kind.UNKNOWN, {"robot_sized"}, True, id="may be long and turn"),
        pytest.param("powerbot", Kind.UNKNOWN, set(), False, id="too small or too large"),
        pytest.param("powerbot", Kind.STRANGER, {"robot_sized"}, True, id="long one in a gap"),
        pytest.param("powerbot", Kind.STRANGER, {"robot_sized", "by_color"}, False, id="no band"),
    ],
)
def test_room_is_kept_round_whatever_may_be_a_robot(
    model: str, kind: Kind, is_like: set[str], *, has_room: bool
) -> None:
    surroundings = surroundings_of(model)
    looked(surroundings, heading=0.0)
    track = Track(
        id=1,
        x=1.5,
        y=0.0,
        vx=-0.3 if "fast" in is_like else 0.0,
        vy=0.0,
        covariance=np.zeros((2, 2)),
        first_seen=0.0,
        last_seen=1.0,
        kind=kind,
        probabilities=Probabilities(0.3, 0.3, 0.4),
        robot_sized="robot_sized" in is_like,
        moving="moving" in is_like,
        by_color="by_color" in is_like,
    )
    origin = Pose(0.0, 0.0, 0.0)
    points = surroundings.around(1.0, origin, origin, [track])
    assert (ObstacleSource.TEAMMATE_ROOM in dict(points.parts)) is has_room
