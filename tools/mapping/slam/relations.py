"""Reference relations between poses, and a trajectory's error against them.

After Kümmerle et al., "On measuring the accuracy of SLAM algorithms" (Autonomous Robots, 2009):
errors of relative poses do not depend on the map's origin.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from maps.pose import Pose, wrap_angle
from tools.logs.log_bytes import LogBytesError, read_log_bytes

PUBLISHED_M = {"scan matching": 0.220, "particle filter": 0.070, "graph mapping": 0.031}
"""Mean translational errors in the paper's table for the Intel Research Lab, m."""


_CLOCK_ERROR = 0.01  # s; largest error of the relations' epoch that is corrected


class RelationsError(ValueError):
    """The file is no list of relations; the message names file, line and remedy."""


@dataclass(frozen=True, slots=True)
class Relation:
    """A true relative pose between two times."""

    start: float
    """Start, log time, s."""
    end: float
    pose: Pose
    """start_from_end."""


@dataclass(frozen=True, slots=True)
class RelationError:
    """Differences of a trajectory's relative poses from the true ones."""

    count: int
    outside: int
    """Relations left out: their times are not in the log."""
    mean_m: float
    median_m: float
    rmse_m: float
    mean_deg: float
    median_deg: float

    def table(self) -> str:
        """Return the errors and, beside them, those published for the Intel Research Lab."""
        published = ", ".join(f"{name} {error:.3f} m" for name, error in PUBLISHED_M.items())
        return (
            f"{self.count} relations ({self.outside} outside the log): mean {self.mean_m:.4f} m, "
            f"median {self.median_m:.4f} m, RMSE {self.rmse_m:.4f} m; mean {self.mean_deg:.2f} "
            f"degrees, median {self.median_deg:.2f} degrees\n"
            f"published means for the Intel Research Lab: {published}"
        )


def read_relations(path: Path, offset: float = 0.0) -> list[Relation]:
    """Read ``t1 t2 x y z roll pitch yaw`` lines, plain or gzip; s, m and rad.

    offset: the relations' time at the log's time zero, s. Raises RelationsError naming file, line
    and remedy.
    """
    try:
        data, truncated = read_log_bytes(path)
        text = data.decode("ascii")
    except OSError as error:
        reason = error.strerror or error
        raise RelationsError(f"{path}: cannot be read ({reason}): check the file") from error
    except (LogBytesError, UnicodeDecodeError) as error:
        raise RelationsError(f"{path}: cannot be read ({error}): copy it again") from error
    if truncated:
        raise RelationsError(f"{path}: cannot be read ({truncated}): copy it again")
    relations = []
    for number, line in enumerate(text.splitlines(), start=1):
        if not line.strip() or line.startswith("#"):
            continue
        try:
            relations.append(_relation(line.split(), offset))
        except ValueError as error:
            raise RelationsError(
                f"{path}: line {number}: {error}: expected 't1 t2 x y z roll pitch yaw'"
            ) from None
    if not relations:
        raise RelationsError(f"{path}: line 1: no relation in the file: give one with some")
    return relations


def _relation(words: list[str], offset: float) -> Relation:
    if len(words) != 8:
        raise ValueError(f"{len(words)} fields instead of 8")
    numbers = [float(word) for word in words]
    if not all(map(math.isfinite, numbers)):
        raise ValueError("a number is not finite")
    start, end, x, y, _, _, _, yaw = numbers
    return Relation(start - offset, end - offset, Pose(x, y, wrap_angle(yaw)))


def synchronize(relations: Sequence[Relation], stamps: Sequence[float]) -> list[Relation]:
    """Return the relations with their times corrected by the log's stamps.

    Relations are between scans, whose stamps the log has: an epoch known to a few milliseconds is
    corrected by the median offset to the nearest stamp. Unchanged if most times have no near stamp.
    stamps: log times, s, sorted.
    """
    times = np.array([t for relation in relations for t in (relation.start, relation.end)])
    known = np.asarray(stamps)
    right = np.clip(np.searchsorted(known, times), 1, len(known) - 1)
    before, after = known[right - 1] - times, known[right] - times
    off = np.where(np.abs(before) < np.abs(after), before, after)
    near = off[np.abs(off) < _CLOCK_ERROR]
    if len(near) < 0.5 * len(times):
        return list(relations)
    shift = float(np.median(near))
    return [
        Relation(relation.start + shift, relation.end + shift, relation.pose)
        for relation in relations
    ]


def relation_error(
    relations: Sequence[Relation], pose_at: Callable[[float], Pose | None]
) -> RelationError:
    """Compare a trajectory with relations.

    pose_at: map_from_laser at a log time, None outside the log. Raises RelationsError if no
    relation lies in the log.
    """
    metres, degrees = [], []
    for relation in relations:
        start, end = pose_at(relation.start), pose_at(relation.end)
        if start is None or end is None:
            continue
        off = relation.pose.between(start.between(end))
        metres.append(math.hypot(off.x, off.y))
        degrees.append(abs(math.degrees(off.theta)))
    if not metres:
        raise RelationsError(
            f"none of the {len(relations)} relations lies in the log's time: "
            "give the relations' time at the log's time zero"
        )
    return RelationError(
        count=len(metres),
        outside=len(relations) - len(metres),
        mean_m=float(np.mean(metres)),
        median_m=float(np.median(metres)),
        rmse_m=float(np.sqrt(np.mean(np.square(metres)))),
        mean_deg=float(np.mean(degrees)),
        median_deg=float(np.median(degrees)),
    )
