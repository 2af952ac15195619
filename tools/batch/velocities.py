"""``action_velocity`` for many robots: compositions of two tasks by priority, in arrays."""

from __future__ import annotations

import numpy as np

from robot_agent.patrol.behaviors import COINCIDENT
from robot_agent.patrol.nsb import DEPENDENT
from robot_agent.patrol.settings import PatrolSettings
from tools.batch.arrays import Codes, Indices, Reals
from tools.batch.situations import PATROLS, SETS_DIRECTION, Act, Situations

Vectors = tuple[Reals, Reals]


def action_velocities(
    at: Situations, action: Codes, direction: Codes, speed: Reals, settings: PatrolSettings
) -> Vectors:
    """Return (vx, vy), each (n,) m/s, map frame, of the actions in force.

    direction: of Keep Going. speed: (n,) of the patrol, m/s.
    """
    limit = settings.approach_speed
    first, claimed = _reaching(at, settings)
    vx, vy = _within_limit(first, limit)
    patrols = PATROLS[action].nonzero()[0]
    if patrols.size == len(action):
        patrols = slice(None)  # type: ignore[assignment] # the usual case: no copies
    sense = SETS_DIRECTION[action[patrols]]
    sense = np.where(sense == 0, direction[patrols], sense)
    onward = _onward(at, sense, speed[patrols], patrols)
    vx[patrols], vy[patrols] = _composed(
        (vx[patrols], vy[patrols]), (claimed[0][patrols], claimed[1][patrols]), onward, limit
    )
    avoids = ((action == Act.AVOID_TEAMMATE) & at.mate).nonzero()[0]
    if avoids.size:
        away = _avoiding(at, avoids, settings)
        reaching = first[0][avoids], first[1][avoids]
        vx[avoids], vy[avoids] = _composed(
            _within_limit(away[:2], limit), away[2:], reaching, limit
        )
    return vx, vy


def _reaching(at: Situations, settings: PatrolSettings) -> tuple[Vectors, Vectors]:
    """Return the velocities of Reach Frontier, and the directions that they claim."""
    away_x, away_y = at.x - at.foot_x, at.y - at.foot_y
    distance = np.hypot(away_x, away_y)
    on_it = distance < COINCIDENT
    distance[on_it] = 1.0
    away_x, away_y = away_x / distance, away_y / distance
    away_x[on_it], away_y[on_it] = -at.ty[on_it], at.tx[on_it]
    distance[on_it] = 0.0
    speed = -np.minimum(settings.reach_gain * distance, settings.approach_speed)
    velocity = speed * away_x, speed * away_y
    beyond = (np.minimum(at.left, at.right) <= 0.0).nonzero()[0]
    if beyond.size:
        away_x[beyond], away_y[beyond] = -at.ty[beyond], at.tx[beyond]
    hidden = at.hidden
    if hidden.size:
        pace = np.minimum(settings.reach_gain * at.way[hidden], settings.approach_speed)
        velocity[0][hidden], velocity[1][hidden] = pace * at.aim_x, pace * at.aim_y
        away_x[hidden], away_y[hidden] = at.aim_x, at.aim_y
    return velocity, (away_x, away_y)


def _onward(at: Situations, sense: Codes, speed: Reals, some: Indices) -> Vectors:
    """Return the velocities along the border, zero beyond an open end or behind a wall."""
    along = sense * speed
    leaves = np.where(sense > 0, at.right[some], at.left[some]) <= 0.0
    if at.hidden.size:
        behind = np.zeros(len(at.x), dtype=np.bool_)
        behind[at.hidden] = True
        leaves |= behind[some]
    along = np.where(leaves, 0.0, along)
    return along * at.tx[some], along * at.ty[some]


def _avoiding(
    at: Situations, some: Indices, settings: PatrolSettings
) -> tuple[Reals, Reals, Reals, Reals]:
    """Return the velocities of Teammate Avoidance, and the directions that they claim."""
    away_x, away_y = at.x[some] - at.mate_x[some], at.y[some] - at.mate_y[some]
    distance = np.hypot(away_x, away_y)
    same = distance < COINCIDENT
    divisor = np.where(same, 1.0, distance)
    away_x = np.where(same, -at.ty[some], away_x / divisor)
    away_y = np.where(same, at.tx[some], away_y / divisor)
    speed = np.maximum(settings.avoid_gain * (settings.safety_distance - distance), 0.0)
    speed = np.minimum(speed, settings.escape_speed)
    return speed * away_x, speed * away_y, away_x, away_y


def _within_limit(velocity: Vectors, limit: float) -> Vectors:
    vx, vy = velocity
    square = vx * vx + vy * vy
    fast = (square > limit**2).nonzero()[0]
    if not fast.size:
        return vx.copy(), vy.copy()
    share = np.ones(len(vx))
    share[fast] = np.minimum(np.sqrt(square[fast] * limit**2) / square[fast], 1.0)
    return share * vx, share * vy


def _composed(velocity: Vectors, claimed: Vectors, second: Vectors, limit: float) -> Vectors:
    """Return the velocities with second tasks in the null space of the claimed directions."""
    vx, vy = velocity
    cx, cy = claimed
    length = np.sqrt(cx * cx + cy * cy)
    none = length <= DEPENDENT
    if none.any():
        length = np.where(none, 1.0, length)
        cx, cy = np.where(none, 0.0, cx), np.where(none, 0.0, cy)
    cx, cy = cx / length, cy / length
    along = second[0] * cx + second[1] * cy
    px, py = second[0] - along * cx, second[1] - along * cy
    a, b = px * px + py * py, vx * px + vy * py
    c = vx * vx + vy * vy - limit**2
    over = ((a != 0.0) & (a + 2.0 * b + c > 0.0)).nonzero()[0]
    if over.size:
        ao, bo, co = a[over], b[over], c[over]
        share = (-bo + np.sqrt(np.maximum(bo * bo - ao * co, 0.0))) / ao
        share = np.minimum(np.maximum(share, 0.0), 1.0)
        px[over] *= share
        py[over] *= share
    return vx + px, vy + py
