"""What happens in a robot, in words for people: one notice a thing."""

from __future__ import annotations

import math
from collections.abc import Sequence

from drivers.scanner import ScannerHealth, ScannerSettings
from robot_agent.messages.log_level import LogLevel
from robot_agent.messages.notice import Notice
from robot_agent.motion.gate import GateDecision
from robot_agent.motion.gate_hold import STOPPING
from robot_agent.motion.gate_reason import LATCHED
from robot_agent.motion.gate_words import GATE_WORDS
from robot_agent.patrol.actions import Action
from robot_agent.patrol.modifier import OverrideReason
from robot_agent.patrol.patrol import PatrolDecision
from robot_agent.patrol.turn_log import TurnCause
from robot_agent.perception.intruders import Intruder
from robot_agent.pose.travel_watch import TravelFault, TravelWatch

TURN_WORDS: dict[str, str] = {
    TurnCause.TEAMMATE: "from a teammate ahead",
    TurnCause.RULES: "at an end, or from a teammate behind",
    TurnCause.CHANCE: "by chance",
    TurnCause.BLOCKAGE: "from an object on its way",
    TurnCause.EVEN_GAPS: "for even gaps",
    TurnCause.COMMON: "together with the team",
}
"""Why a robot turned back, by the cause in its decision."""
TRAVEL_WORDS: dict[str, str] = {
    TravelFault.TURNED: "laser.mount: correct it there, or by `patrol calibrate laser`",
    TravelFault.MIRRORED: "the laser sees the robot turn the other way: correct laser.upside_down,"
    " or see laser.mount for a mirrored one",
    TravelFault.REPEATS: "the laser sees no motion while the wheels turn: it repeats its scan, or"
    " the robot is stuck; no fault of laser.mount",
}
UNCONFIRMED_S = 20.0
"""s from the first scan, after which a robot that has not come away from its start says so."""
UNCONFIRMED_WORDS = (
    "not confirmed, as something has held the robot since its start: if nothing is there, correct"
    " laser.mount, or laser.ignore for its own parts"
)
_REMEDY = "look at the robot, then switch its motors off and on by its MOTORS button"


def override_notice(
    t: float, decision: PatrolDecision, before: PatrolDecision | None
) -> Notice | None:
    """Return a notice if an override begins in a decision that is worth one."""
    reason = decision.override
    if reason is None or (before is not None and before.override is reason):
        return None
    place = f"near s = {decision.abscissa:.1f} m"
    match reason:
        case OverrideReason.BLOCKAGE:
            turned = "" if decision.turn is None else ", turns back"
            words = f"unknown object {place} holds the robot{turned}"
            return Notice(t, "patrol", words, LogLevel.WARNING)
        case OverrideReason.CLOSING_IN:
            words = f"comes closer to a teammate {place} that always sent it back there"
            return Notice(t, "patrol", words, LogLevel.INFO)
        case OverrideReason.STANDOFF:
            return Notice(t, "standoff", _standoff_words(decision, place), LogLevel.INFO)
        case _:
            return None


def way_notice(t: float, decision: PatrolDecision, before: PatrolDecision | None) -> Notice | None:
    """Return a notice if the way to the border ends, or is there again, with a decision."""
    without = math.isinf(decision.way_to_border)
    if without == (before is not None and math.isinf(before.way_to_border)):
        return None
    if not without:
        return Notice(t, "border", "there is a way to the border again", LogLevel.INFO)
    words = (
        "no way to the border between the walls for a robot of this size: drive it to a wider"
        " place, or give it a border that it can reach"
    )
    return Notice(t, "border", words, LogLevel.WARNING)


def _standoff_words(decision: PatrolDecision, place: str) -> str:
    match decision.action:
        case Action.REACH_FRONTIER:
            return f"kept from the border {place} for too long, drives to it"
        case Action.KEEP_GOING:
            return f"avoided teammates {place} for too long, goes on"
        case _:
            return f"caught at the border's end {place} for too long, leaves it"


def gate_notice(t: float, gate: GateDecision) -> Notice:
    """Return a notice of whether the gate holds the robot, and what releases it."""
    if gate.reason not in STOPPING:
        return Notice(t, "gate", "lets the robot move", LogLevel.INFO)
    remedy = f" ({_REMEDY})" if gate.reason in LATCHED else ""
    return Notice(
        t, "gate", f"holds the robot: {GATE_WORDS[gate.reason]}{remedy}", LogLevel.WARNING
    )


def travel_notice(t: float, watch: TravelWatch, *, held: bool, warned: bool) -> Notice | None:
    """Return a notice of what the watch of travel has found, with a remedy; None if nothing.

    held: whether an obstacle holds the robot. warned: whether the last notice was a warning.
    """
    if watch.confirmed and warned and watch.fault is None:
        return Notice(t, "laser.mount", "scans show the motion of the wheels", LogLevel.INFO)
    if watch.fault is None:
        late = watch.began is not None and t - watch.began > UNCONFIRMED_S
        if watch.confirmed or not (held and late):
            return None
        return Notice(t, "laser.mount", UNCONFIRMED_WORDS, LogLevel.WARNING)
    words = TRAVEL_WORDS[watch.fault]
    if watch.fault is TravelFault.TURNED:
        side = "left" if watch.turned_deg > 0 else "right"
        words = f"the laser is turned about {abs(watch.turned_deg)} deg to the {side} of {words}"
    return Notice(t, "laser.mount", words, LogLevel.ERROR)


def scale_notice(t: float, off: float | None, *, warned: bool) -> Notice | None:
    """Return a notice of scans and wheels that show different ways; None if nothing is new.

    off: share by which scans show more, None within the tolerance. warned: as of ``travel_notice``.
    """
    if off is None:
        well = "scans show as much way as the wheels count"
        return Notice(t, "base.wheel_scale", well, LogLevel.INFO) if warned else None
    if warned:
        return None
    words = (
        f"scans show {abs(off):.0%} {'more' if off > 0.0 else 'less'} way than the wheels count:"
        " `patrol calibrate odometry`; if the wheels are right the laser's ranges are not"
    )
    return Notice(t, "base.wheel_scale", words, LogLevel.WARNING)


def own_parts_notice(
    t: float, laser: ScannerSettings, sectors: Sequence[tuple[float, float]], *, stand_out: bool
) -> Notice | None:
    """Return a notice of the robot's own parts in the laser's view; None if there are none.

    sectors: first and last direction of each, rad, laser frame. stand_out: of the footprint.
    """
    if not sectors:
        return None
    found = laser.degrees_of(sectors)
    places = ", ".join(f"{first} to {last}" for first, last in found)
    every = sorted([*found, *map(list, laser.ignore)])
    words = f"the laser sees parts of the robot at {places} deg: set laser.ignore = {every}"
    if not stand_out:
        return Notice(t, "laser.ignore", words, LogLevel.INFO)
    words += ", and in a model file (base.model) the body with these parts, that stand out of it"
    return Notice(t, "laser.ignore", words, LogLevel.ERROR)


def laser_health_notice(t: float, health: ScannerHealth | None, *, warned: bool) -> Notice | None:
    """Return a notice of what the laser reports of itself; None if it is well and was.

    warned: whether the last notice was a warning.
    """
    if health is None or (health.ok and not warned):
        return None
    level = LogLevel.INFO if health.ok else LogLevel.WARNING
    return Notice(t, "laser.health", health.text, level)


def intruder_notice(t: float, intruder: Intruder) -> Notice:
    """Return a notice of a new intruder and its place."""
    words = (
        f"intruder {intruder.number} at ({intruder.x:.1f}, {intruder.y:.1f}), "
        f"{intruder.distance:.1f} m from the border at s = {intruder.abscissa:.1f} m"
    )
    return Notice(t, "intruder", words, LogLevel.WARNING)
