"""Poses of a log's scans from raw odometry and the scans alone.

1. Each keyframe is matched with those before it (``chain``).
2. Revisited places are found and close loops (``loop_closer``).
3. All scans near each other are aligned pairwise, in one graph (``refinement``).
4. The odometry interpolates the keyframes' poses for all scans (``trajectory``).
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np

from maps.pose import Pose
from tools.logs.carmen import LogError
from tools.logs.scan_log import ScanLog
from tools.mapping.slam.chain import build_chain
from tools.mapping.slam.keyframe import choose_keyframes, make_keyframe
from tools.mapping.slam.loop_check import MOST_STRAIN, CheckedLoop
from tools.mapping.slam.loop_closer import LoopCloser
from tools.mapping.slam.pose_graph import Edge
from tools.mapping.slam.refinement import refine
from tools.mapping.slam.rigid_fit import fit
from tools.mapping.slam.trajectory import Trajectory
from tools.progress import progress_line

_LEAST_KEYFRAMES = 3


@dataclass(frozen=True, slots=True, eq=False)
class Mapping:
    """The poses of a log's scans and their quality."""

    log: ScanLog
    """The log with the poses found as references."""
    trajectory: Trajectory
    keyframes: int
    loops: list[CheckedLoop]
    """Loops closed, and those dropped again."""
    bend: tuple[float, Pose]
    """By how many standard deviations the chain was bent most, and where (map_from_laser)."""
    loop_correction: float
    """Largest distance by which loop closing moved a keyframe, m."""
    pairs: int
    """Number of aligned pairs of scans."""
    disagreement: float
    """Median distance between pairs' measured relative poses and the result, m."""
    off_references: float | None
    """Mean distance from the log's own reference poses, m; None if it has none."""
    unmatched: list[tuple[Pose, float]]
    """Pieces of the way that rest on odometry alone: middle (map_from_laser) and length, m."""
    seconds: float
    """Time of the computation, s."""

    @property
    def strains(self) -> list[float]:
        """Strain of each loop that was kept."""
        return [loop.strain for loop in self.loops if loop.kept]

    def summary(self) -> str:
        """Return two lines for people: loops and time; pairs and their residual."""
        strained = (
            f", strain up to {max(self.strains):.1f} of {MOST_STRAIN:.1f} sigma"
            if self.strains
            else ""
        )
        off = (
            ""
            if self.off_references is None
            else f", {self.off_references:.3f} m mean off the log's own poses"
        )
        return (
            f"{self.keyframes} keyframes, {len(self.strains)} loops closed that moved them up to "
            f"{self.loop_correction:.2f} m in {self.seconds:.1f} s{strained}\n"
            f"{self.pairs} pairs of scans, {self.disagreement:.3f} m median off the poses{off}"
        )


def map_from_odometry(log: ScanLog) -> Mapping:
    """Return the poses of all scans from raw odometry, without the log's references.

    The result is then moved as a whole to fit the log's references, if there are any, for
    comparison. Raises LogError for a log without motion.
    """
    started = time.perf_counter()
    chosen = choose_keyframes(log.scans)
    if len(chosen) < _LEAST_KEYFRAMES:
        raise LogError(
            f"{log.path}: {len(chosen)} scans a step apart, too few to find poses by: drive farther"
        )
    frames = [make_keyframe(log.scans[index]) for index in chosen]
    with progress_line("chain", len(frames), "keyframes") as progress:
        chain, edges = build_chain(frames, progress)
    closer = LoopCloser(frames, chain, edges)
    with progress_line("loops", len(frames), "keyframes") as progress:
        closer.close(progress)
    with progress_line("refine", len(frames), "keyframes") as progress:
        refined = refine(frames, closer.poses, edges + closer.loops, progress)
    moved = [math.dist(a[:2], b[:2]) for a, b in zip(chain, closer.poses, strict=True)]

    poses, off = refined.poses, None
    if log.referenced:
        references = [log.scans[index].reference for index in chosen]
        frame = fit(poses, references)
        poses = [frame.compose(pose) for pose in poses]
        off = _mean_distance(poses, references)
    bend, bent = closer.bend(poses)
    marks = {log.scan_lines[index]: pose for index, pose in zip(chosen, poses, strict=True)}
    trajectory = Trajectory(log.odometry, marks)
    return Mapping(
        log=log.with_references([trajectory.poses[line] for line in log.scan_lines]),
        trajectory=trajectory,
        keyframes=len(frames),
        loops=closer.checked(poses),
        bend=(bend, poses[bent]),
        loop_correction=max(moved),
        pairs=len(refined.pairs),
        disagreement=refined.disagreement(),
        off_references=off,
        unmatched=_unmatched(poses, [*edges, *closer.loops, *refined.pairs]),
        seconds=time.perf_counter() - started,
    )


def _unmatched(poses: list[Pose], edges: list[Edge]) -> list[tuple[Pose, float]]:
    """Return the pieces of the way whose steps have no edge by scans."""
    matched = {edge.end for edge in edges if edge.robust and edge.start == edge.end - 1}
    pieces, begin, length = [], 0, 0.0
    for end in range(1, len(poses) + 1):
        if end < len(poses) and end not in matched:
            length += math.dist(poses[end - 1][:2], poses[end][:2])
            continue
        if length > 0.0:
            pieces.append((poses[(begin + end - 1) // 2], length))
        begin, length = end, 0.0
    return pieces


def _mean_distance(poses: list[Pose], references: list[Pose]) -> float:
    return float(np.mean([math.dist(a[:2], b[:2]) for a, b in zip(poses, references, strict=True)]))
