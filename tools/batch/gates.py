"""``SafetyGate`` for many robots with ideal sensing: everything is fresh, known and in view."""

from __future__ import annotations

import math

import numpy as np

from robot_agent.motion.gate import BEGUN, MORE_ROOM, TURNED_AWAY
from robot_agent.motion.gate_hold import CRAWL, CREEPING_TURN
from robot_agent.motion.gate_limits import GateLimits
from robot_agent.motion.stopping import stopping_way
from robot_agent.motion.swept_footprint import (
    EDGING_SHARE,
    FREE_SHARES,
    LEAST_BACK,
    SEEN_INSIDE,
    SHARES,
)
from robot_agent.motion.unpinning import EDGING_SPEED
from tools.batch.arrays import Flags, Indices, Reals, pick
from tools.batch.obstacle_points import ObstaclePoints


class SafetyGates:
    """Limits the commands of each robot; keeps the last one."""

    def __init__(self, limits: GateLimits, n: int) -> None:
        self._limits = limits
        self._swept = SweptFootprints(limits)
        self.v = np.zeros(n)
        self.w = np.zeros(n)
        self._acceleration = np.zeros(n)
        self._obstacle = np.zeros(n, dtype=np.bool_)
        self._stops = np.zeros(n, dtype=np.bool_)
        self._blocked = np.zeros((2, n), dtype=np.bool_)  # turns in place, to the right and left
        self._away = np.zeros((2, n))  # rad turned away since
        self._turned = np.zeros(n)  # rad, + left, since the robot turned the other way
        self._been = np.zeros((2, n))  # rad to right and left within which the body has been
        self.stops = np.zeros(n, dtype=np.intp)
        """How often an obstacle held each robot, from its begin."""

    def permit(
        self,
        dt: float,
        requested: tuple[Reals, Reals],
        measured: tuple[Reals, Reals],
        obstacles: ObstaclePoints,
        counted: Flags,
    ) -> None:
        """Set v and w to the permitted part of the requested ones, dt s after the last.

        measured: (v, w) of the base. counted: whose stops count.
        """
        self._count_turns(measured[1] * dt)
        ramped = self._ramped(*self._within_speed(*requested), dt)
        v, w = ramped[0].copy(), ramped[1].copy()
        some = obstacles.robots
        self._obstacle[:] = False
        self._release(np.maximum(v, measured[0]), w, some)
        if some.size:
            inputs = ramped[0][some], ramped[1][some], measured[0][some], measured[1][some]
            v[some], w[some] = self._within_sight(*inputs, obstacles)
            self._obstacle[some] = (v[some] != inputs[0]) | (w[some] != inputs[1])
        self._acceleration = np.maximum(v - self.v, 0.0) / dt if dt else np.zeros(len(v))
        # Nothing else can stop a robot here: no denials, and all its way is in view.
        self.stops += self._obstacle & ~self._stops & counted
        self._stops = self._obstacle.copy()
        self.v, self.w = v, w

    def pick(self, robots: Indices) -> None:
        """Keep some robots, as ``arrays.pick`` does."""
        names = (
            "v",
            "w",
            "_acceleration",
            "_obstacle",
            "_stops",
            "_blocked",
            "_away",
            "_turned",
            "_been",
            "stops",
        )
        pick(self, names, robots)

    def held(self) -> Flags:
        """Return which robots an obstacle stops, or nearly (``held_by_obstacle``)."""
        return self._obstacle & (self.v < CRAWL)

    def pinned(self) -> Flags:
        """Return which robots may neither drive nor turn (``pinned_by_obstacle``)."""
        return self.held() & (np.abs(self.w) < CREEPING_TURN)

    def _within_speed(self, v: Reals, w: Reals) -> tuple[Reals, Reals]:
        limits = self._limits
        size = np.abs(w)
        fast = ((v > limits.max_speed) | (size > limits.max_turn_rate)).nonzero()[0]
        if fast.size:
            share = np.minimum(
                limits.max_speed / np.maximum(v[fast], limits.max_speed),
                limits.max_turn_rate / np.maximum(size[fast], limits.max_turn_rate),
            )
            v, w = v.copy(), w.copy()
            v[fast] *= share
            w[fast] *= share
        return v, w

    def _ramped(self, v: Reals, w: Reals, dt: float) -> tuple[Reals, Reals]:
        limits = self._limits
        turn = limits.max_turn_acceleration * dt
        acceleration = np.minimum(
            limits.max_acceleration, self._acceleration + limits.max_jerk * dt
        )
        return (
            np.minimum(v, self.v + acceleration * dt),
            np.minimum(np.maximum(w, self.w - turn), self.w + turn),
        )

    def _release(self, rolling: Reals, w: Reals, near: Indices) -> None:
        """Forget what stopped turns of robots that drive, or turn, without an obstacle near."""
        alone = np.ones(len(w), dtype=np.bool_)
        alone[near] = False
        drives = rolling > self._limits.creep_speed
        self._turned[alone & drives] = 0.0
        self._been[:, alone & drives] = 0.0
        self._blocked[0, alone & (drives | (w < 0.0))] = False
        self._blocked[1, alone & (drives | (w > 0.0))] = False

    def _within_sight(
        self, v: Reals, w: Reals, base_v: Reals, base_w: Reals, obstacles: ObstaclePoints
    ) -> tuple[Reals, Reals]:
        """Return (v, w) of the robots with obstacles near, reduced as ``SafetyGate`` does."""
        limits = self._limits
        delay = limits.reaction_delay
        rolling = np.maximum(v, base_v)
        spin = np.where(w * base_w > 0.0, np.maximum(np.abs(w), np.abs(base_w)), np.abs(w))
        turn = _ways(spin, limits.turn_braking, delay)
        done = np.zeros(len(v), dtype=np.bool_)
        out_v, out_w = np.zeros(len(v)), w.copy()
        rolls = (rolling > limits.creep_speed).nonzero()[0]
        if rolls.size:
            stop = _ways(rolling[rolls], limits.braking, delay)
            along = stop * np.abs(w[rolls]) / rolling[rolls]
            arc = np.copysign(np.maximum(along, turn[rolls]), w[rolls])
            free = stop * self._swept.free_shares(stop, arc, obstacles.of(rolls))
            clear = free == stop
            late = ~clear & (_ways(base_v[rolls], limits.braking, 0.0) > free)
            slow = np.minimum(v[rolls], _stoppable(free, limits.braking, delay))
            creeps = ~clear & ~late & (slow > limits.creep_speed)
            out_v[rolls] = np.where(clear, v[rolls], np.where(creeps, slow, 0.0))
            slowed = w[rolls] * slow / rolling[rolls]
            out_w[rolls] = np.where(clear, w[rolls], np.where(creeps, slowed, 0.0))
            done[rolls] = clear | late | creeps
            drive = obstacles.robots[rolls[clear | creeps]]
            self._blocked[:, drive], self._turned[drive], self._been[:, drive] = False, 0.0, 0.0
        turns = (~done).nonzero()[0]
        if turns.size:
            own = w[turns]
            angle = np.copysign(turn[turns], own)
            share = self._free_turns(angle, turns, obstacles)
            free = turn[turns] * share
            rate = np.minimum(np.abs(own), _stoppable(free, limits.turn_braking, delay))
            out_w[turns] = np.where(free == turn[turns], own, np.copysign(rate, own))
        return out_v, out_w

    def _free_turns(self, turn: Reals, some: Indices, obstacles: ObstaclePoints) -> Reals:
        """Return the free shares of turns in place, rad, of some robots near obstacles."""
        robots, left = obstacles.robots[some], (turn > 0.0).astype(np.intp)
        more = np.where(self._blocked[left, robots] & (turn != 0.0), MORE_ROOM, 0.0)
        back = np.abs(turn) <= self._been[left, robots]
        share = self._swept.free_shares(np.zeros(len(turn)), turn, obstacles.of(some), more, back)
        turns = turn != 0.0
        begun = np.sign(turn) * self._turned[robots] > BEGUN
        ends, begins = turns & (share > 0.0), (share == 0.0) & begun
        self._blocked[left[ends], robots[ends]] = False
        self._blocked[left[begins], robots[begins]] = True
        self._away[left[begins], robots[begins]] = 0.0
        return share

    def _count_turns(self, turned: Reals) -> None:
        """Add what robots have turned (n,), rad; let go of the sides they have turned away from."""
        self._turned = turned + np.where(self._turned * turned >= 0.0, self._turned, 0.0)
        from_sides = np.stack((turned, -turned))
        self._away = np.maximum(self._away + from_sides, 0.0)
        self._been = np.maximum(self._been + from_sides, 0.0)
        self._blocked &= self._away <= TURNED_AWAY


class SweptFootprints:
    """``SweptFootprint.free_share`` for many arcs, each among obstacles of its own."""

    def __init__(self, limits: GateLimits) -> None:
        self._limits = limits
        speed = EDGING_SHARE * EDGING_SPEED
        self._edging_way = stopping_way(speed, limits.braking, limits.reaction_delay)
        self._reach = limits.front + limits.rear + limits.half_width
        widest = limits.half_width + max(limits.margin, limits.turn_margin)
        longest = max(limits.front + limits.front_margin, limits.rear + limits.turn_margin)
        self._corner = math.hypot(longest, widest) + 2.0 * MORE_ROOM

    def free_shares(
        self,
        way: Reals,
        turn: Reals,
        points: ObstaclePoints,
        more: Reals | None = None,
        back: Flags | None = None,
    ) -> Reals:
        """Return (n,) the shares, 0 to 1, of arcs (way m, turn rad) that are free of points.

        more (n,): m added to the margin of turns in place; back (n,): which go back to where the
        body has been: points within the margin must only come no nearer. Both None where robots
        drive.
        """
        limits = self._limits
        robot, x, y = points.owner, points.x, points.y
        n = len(way)
        near = np.maximum(np.abs(x), np.abs(y)) < way[robot] + self._reach
        robot, x, y = robot[near], x[near], y[near]
        drives = way > 0.0
        # 1. The footprint with its margins: beside the body as much as the points alongside leave.
        front = np.where(
            drives, limits.front + limits.front_margin, limits.front + limits.turn_margin
        )
        margin = np.where(drives, limits.margin, limits.turn_margin)
        alongside = (x < limits.front) & (x > -limits.rear)
        np.minimum.at(margin, robot[alongside], np.abs(y[alongside]) - limits.half_width)
        side = limits.half_width + np.maximum(margin, limits.turn_margin)
        # 2. The points that it can meet.
        close = x * x + y * y < (way[robot] + self._corner) ** 2
        edges = drives & (turn == 0.0) & (way <= self._edging_way)
        if edges.any():
            beside = (np.abs(y) >= limits.half_width - SEEN_INSIDE) & (x < limits.front)
            behind = x <= SEEN_INSIDE - limits.rear
            close &= ~(edges[robot] & (beside | behind))
        robot, x, y = robot[close], x[close], y[close]
        shares = np.ones(n)
        if not len(robot):
            return shares
        # 3. The first pose along the arc at which it does.
        rear = limits.rear + limits.turn_margin
        room: Reals | float = 0.0
        if more is not None and back is not None:
            room = self._more_room(more[robot], back[robot], x, y)
        seen_x, seen_y = _seen_along_arcs(way, turn, robot, x, y)
        hit = (
            (seen_x < front[robot] + room)
            & (seen_x > -rear - room)
            & (np.abs(seen_y) < side[robot] + room)
        )
        first = np.where(hit.any(axis=0), hit.argmax(axis=0), len(SHARES))
        pose = np.full(n, len(SHARES))
        np.minimum.at(pose, robot, first)
        hits = pose < len(SHARES)
        shares[hits] = FREE_SHARES[pose[hits]]
        return shares

    def _more_room(self, more: Reals, back: Flags, x: Reals, y: Reals) -> Reals:
        """Return (m,) what points (m,) add to the margin of a turn in place, at most more, m.

        Negative for points within the margin of a turn back (m,).
        """
        limits = self._limits
        beyond = np.maximum(x - limits.front, -limits.rear - x)
        clearance = np.maximum(beyond, np.abs(y) - limits.half_width)
        least = np.where(back, LEAST_BACK - limits.turn_margin, 0.0)
        return np.asarray(np.clip(clearance - limits.turn_margin, least, more))


def _seen_along_arcs(
    way: Reals, turn: Reals, robot: Indices, x: Reals, y: Reals
) -> tuple[Reals, Reals]:
    """Return (x, y), each (poses, m): points (m,) as seen from poses along their robots' arcs."""
    turns = SHARES[:, None] * turn
    half = turns / 2.0
    chord = SHARES[:, None] * way * np.sinc(half / np.pi)
    c, s = np.cos(turns)[:, robot], np.sin(turns)[:, robot]
    back_x, back_y = (chord * np.cos(half))[:, robot], (chord * np.sin(half))[:, robot]
    return c * x + s * y - back_x, c * y - s * x + back_y


def _ways(rate: Reals, braking: float, delay: float) -> Reals:
    return rate * rate / (2.0 * braking) + rate * delay


def _stoppable(way: Reals, braking: float, delay: float) -> Reals:
    return np.asarray(braking * (np.sqrt(delay * delay + 2.0 * way / braking) - delay))
