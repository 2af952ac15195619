"""Runs of the ideal bench side by side: the robots of all runs take each step together.

The decision layer of ``IdealFleet`` in arrays over all robots of all runs, with the same draws and
the same arithmetic but for rounding. Runs differ by seed and faults; map and settings are common.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy

import numpy as np

from drivers.p2os.model_choice import expected_model
from maps.map_folder import MapFolder
from maps.pose import Pose
from robot_agent.config import AgentConfig
from robot_agent.motion.gate_settings import gate_limits
from robot_agent.patrol.common_clock import CommonClock
from tools.batch.arrays import Flags, Reals, pick
from tools.batch.bodies import REACH, STEP_WAY, Bodies
from tools.batch.border_feet import BorderFeet
from tools.batch.gates import SafetyGates
from tools.batch.heading_loops import HeadingLoops, Unpinnings
from tools.batch.obstacle_points import Obstacles
from tools.batch.patrols import Decisions, Patrols, has_arrays
from tools.batch.sights import Sights
from tools.bench.bench_fault import BenchFault, BenchFaultError, FaultKind, check_robots, wrecks_of
from tools.bench.ideal_fleet import secret_of
from tools.bench.ideal_robot import STEP_S
from tools.metrics.wreck import Wreck
from tools.simulation.robot_body import Outline
from tools.simulation.start_poses import free_start_poses
from tools.simulation.truth.truth import load_truth
from tools.simulation.world import World


class Batch:
    """Teams of equal size on one map, one run per seed, under one virtual clock."""

    def __init__(
        self,
        folder: MapFolder,
        robots: int,
        seeds: Sequence[int],
        config: AgentConfig | None = None,
        starts: Sequence[Sequence[Pose]] | None = None,
        faults: Sequence[Sequence[BenchFault]] = (),
        clocks: Sequence[CommonClock] = (),
    ) -> None:
        """Place the robots of each run as ``IdealFleet`` of its seed places them.

        starts: instead, of each run. faults: of each run; none by default. clocks: of all robots,
        one run after the other; right ones by default.
        Raises BenchFaultError for a fault that is not a permanent death or stuck wheels.
        """
        assert folder.border is not None, "robots patrol a border"
        self.folder, self.seeds, self.robots = folder, tuple(seeds), robots
        self.config = config = config or AgentConfig()
        self.t = 0.0
        rng = np.random.default_rng(self.seeds[0])
        world = World(folder.map, rng, load_truth("ideal").noise)
        self.bodies = Bodies(world, starts or [_starts(folder, robots, seed) for seed in seeds])
        self.n = n = len(self.seeds) * robots
        self.names = [f"robot{number + 1}" for number in range(robots)]
        self.faults = [tuple(each) for each in faults] or [()] * len(self.seeds)
        for each in self.faults:
            _check_faults(each, self.names)
        self.dead, self._stuck = np.zeros((2, n), dtype=np.bool_)
        limits = gate_limits(config.gate, expected_model(config.base))
        rngs = [
            np.random.default_rng(seed * 1000 + number)
            for seed in seeds
            for number in range(robots)
        ]
        self.patrols = Patrols(
            config.patrol,
            folder.border,
            BorderFeet(folder.border),
            rngs,
            folder.approach_field,
            clocks or [CommonClock(0.0)] * n,
            [secret_of(config, seed) for seed in seeds for _ in range(robots)],
        )
        self._sights = Sights(
            config.perception.detection_range,
            folder.map,
            len(self.seeds),
            robots,
            config.laser.field_of_view_deg,
        )
        self._obstacles = Obstacles(limits, folder.map, folder.border)
        self._loops, self._unpinnings = HeadingLoops(n), Unpinnings(n)
        self._gates = SafetyGates(limits, n)
        self.decisions: Decisions | None = None
        """Of the last step; those of a dead robot mean nothing."""

    def branched(self, copies: int, seed: int) -> Batch:
        """Return a batch with ``copies`` of each run as it is now, but other chances from now on.

        The copies of a run follow each other; their generators come from ``seed``.
        """
        walls = self.bodies.shared
        shared = (self.folder, self.config, self._obstacles, *walls, *self.patrols.shared)
        memo = {id(thing): thing for thing in shared}
        twin = deepcopy(self, memo)
        runs = np.repeat(np.arange(len(self.seeds)), copies)
        robots = (runs[:, None] * self.robots + np.arange(self.robots)).ravel()
        twin.seeds = tuple(self.seeds[run] for run in runs.tolist())
        twin.faults = [self.faults[run] for run in runs.tolist()]
        twin.n = len(robots)
        twin.patrols.pick(
            robots, [np.random.default_rng((seed, number)) for number in range(twin.n)]
        )
        twin.patrols.draw_anew(seed, self.robots)
        for part in (twin.bodies, twin._sights, twin._loops, twin._unpinnings, twin._gates):
            part.pick(robots)
        pick(twin, ("dead", "_stuck"), robots)
        if twin.decisions is not None:
            pick(twin.decisions, Decisions.__slots__, robots)
        return twin

    @property
    def order(self) -> tuple[Reals, Reals]:
        """The permitted commands (v, w) of all robots, m/s and rad/s."""
        alive = ~self.dead
        return self._gates.v * alive, self._gates.w * alive

    def gate_stops(self, run: int) -> int:
        """Return how often the gates of a run's robots held them."""
        return int(self._gates.stops[self._of(run)].sum())

    def wrecks(self, run: int) -> list[Wreck]:
        """Return the robots of a run that a fault has stopped permanently by now."""
        first = run * self.robots
        poses = {name: self.bodies.pose(first + own) for own, name in enumerate(self.names)}
        return wrecks_of(self.faults[run], poses, self.t)

    def step(self) -> None:
        """Advance all runs by STEP_S: motion, sensing, decisions."""
        before, self.t = self.t, round(self.t + STEP_S, 6)
        # By the clock, as the agents reckon it: rounded otherwise, thresholds are met later.
        dt = 0.0 if self.decisions is None else self.t - before
        self._inject()
        bodies = self.bodies
        # 1. Motion.
        order = self.order
        way, rotation = bodies.roll(order, self._stuck, STEP_S)
        bodies.move(way, rotation, self._sights.closest, self._near_walls())
        # 2. Sensing.
        mates = self._look()
        fastest = np.maximum(bodies.v, order[0])
        poses = bodies.x, bodies.y, bodies.cos, bodies.sin
        made = self.decisions
        points = self._obstacles.around(
            poses,
            fastest,
            self._sights.apart,
            None if made is None else made.on_patrol,
        )
        # 3. Decisions.
        pinned = self._gates.pinned()
        made = self.patrols.step(
            self.t, bodies.x, bodies.y, bodies.theta, mates, self._gates.held()
        )
        pins = self._unpinnings.step(self.t, self._loops, pinned)
        requested = self._loops.command(dt, (made.vx, made.vy), bodies.theta, made.curvature, pins)
        self._gates.permit(dt, requested, (bodies.v, bodies.w), points, ~self.dead)
        self.decisions = made

    def _of(self, run: int) -> slice:
        return slice(run * self.robots, (run + 1) * self.robots)

    def _inject(self) -> None:
        """Begin and end faults."""
        for run, faults in enumerate(self.faults):
            for fault in faults:
                robot = run * self.robots + self.names.index(fault.robot)
                of_kind = self.dead if fault.kind is FaultKind.DEAD else self._stuck
                of_kind[robot] = fault.holds(self.t)

    def _near_walls(self) -> Flags:
        """Return (n,) which robots can touch a wall in a step."""
        x, y, made = self.bodies.x, self.bodies.y, self.decisions
        reach = REACH + STEP_WAY
        if made is None:
            return ~self._obstacles.free(x, y, reach)
        near = made.distance + STEP_WAY + reach >= self._obstacles.border_clearance
        some = near.nonzero()[0]
        near[some] = ~self._obstacles.free(x[some], y[some], reach)
        return near

    def _look(self) -> tuple[Flags, Reals, Reals]:
        bodies = self.bodies
        middle = Outline().middle
        base, heading = (bodies.x, bodies.y), (bodies.cos, bodies.sin)
        ahead = bodies.x + middle * bodies.cos, bodies.y + middle * bodies.sin
        return self._sights.look(self.t, base, heading, ahead, bodies.v)


def _starts(folder: MapFolder, robots: int, seed: int) -> list[Pose]:
    assert folder.border is not None
    return free_start_poses(folder.map, folder.border, robots, np.random.default_rng(seed))


def is_possible(config: AgentConfig, faults: Sequence[BenchFault]) -> bool:
    """Return whether a run with a configuration and faults can be one of a batch."""
    return has_arrays(config.patrol) and all(map(_is_possible, faults))


def _is_possible(fault: BenchFault) -> bool:
    lasting = fault.kind is FaultKind.DEAD and fault.is_permanent
    return lasting or fault.kind is FaultKind.STUCK


def _check_faults(faults: Sequence[BenchFault], names: list[str]) -> None:
    check_robots(faults, names)
    for fault in faults:
        if not _is_possible(fault):
            raise BenchFaultError(
                f"fault {fault.kind} of {fault.robot}: a batch has robots that die for good or are "
                "stuck, use patrol bench for others"
            )
