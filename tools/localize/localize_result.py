"""Result of a run of the localizer over a log: a row per scan, and a summary."""

from __future__ import annotations

import csv
import dataclasses
import math
import resource
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from localization.estimate import Estimate
from localization.health import Health
from maps.pose import Pose, wrap_angle
from maps.whole_file import whole_file
from tools.logs.csv_cells import csv_cells

ASTRAY_M = 1.0
"""An estimate farther than this from the reference counts as lost, whatever its health."""

CHI_SQUARE_2, CHI_SQUARE_3 = 5.991, 7.815
"""95 % quantiles of the chi-square distribution of 2 and 3 degrees of freedom."""


@dataclass(frozen=True, slots=True)
class LocalizeRow:
    """One scan's estimate (map_from_base; m, rad) and errors; None without a reference."""

    t: float
    x: float
    y: float
    theta: float
    reference_x: float | None
    reference_y: float | None
    reference_theta: float | None
    position_error_m: float | None
    heading_error_deg: float | None
    cov_xx: float
    cov_xy: float
    cov_xtheta: float
    cov_yy: float
    cov_ytheta: float
    cov_thetatheta: float
    health: str
    likelihood: float
    particles: int
    effective_sample_size: float
    update_ms: float

    @classmethod
    def of(cls, estimate: Estimate, reference: Pose | None, update_ms: float) -> LocalizeRow:
        """Return the row of an estimate; reference: true map_from_base, None if unknown."""
        pose, covariance = estimate.pose, estimate.covariance
        position = heading = None
        if reference is not None:
            position = math.hypot(pose.x - reference.x, pose.y - reference.y)
            heading = abs(math.degrees(wrap_angle(pose.theta - reference.theta)))
        return cls(
            t=estimate.t,
            x=pose.x,
            y=pose.y,
            theta=pose.theta,
            reference_x=None if reference is None else reference.x,
            reference_y=None if reference is None else reference.y,
            reference_theta=None if reference is None else reference.theta,
            position_error_m=position,
            heading_error_deg=heading,
            cov_xx=float(covariance[0, 0]),
            cov_xy=float(covariance[0, 1]),
            cov_xtheta=float(covariance[0, 2]),
            cov_yy=float(covariance[1, 1]),
            cov_ytheta=float(covariance[1, 2]),
            cov_thetatheta=float(covariance[2, 2]),
            health=str(estimate.health),
            likelihood=estimate.likelihood,
            particles=estimate.particle_count,
            effective_sample_size=estimate.effective_sample_size,
            update_ms=update_ms,
        )

    @property
    def covariance(self) -> NDArray[np.float64]:
        """The estimate's (3, 3) covariance of x, y, theta; m^2, m rad, rad^2."""
        return np.array(
            (
                (self.cov_xx, self.cov_xy, self.cov_xtheta),
                (self.cov_xy, self.cov_yy, self.cov_ytheta),
                (self.cov_xtheta, self.cov_ytheta, self.cov_thetatheta),
            )
        )

    @property
    def away(self) -> NDArray[np.float64] | None:
        """(3,) reference minus estimate, m and rad; None without a reference."""
        if self.reference_x is None or self.reference_y is None or self.reference_theta is None:
            return None
        turn = wrap_angle(self.reference_theta - self.theta)
        return np.array((self.reference_x - self.x, self.reference_y - self.y, turn))

    @property
    def is_lost(self) -> bool:
        """Whether the health is lost, or the position error exceeds ``ASTRAY_M``."""
        astray = self.position_error_m is not None and self.position_error_m > ASTRAY_M
        return astray or self.health == Health.LOST


@dataclass(frozen=True, slots=True)
class Coverage:
    """Shares of the references inside the estimates' 95 % ellipses; consistent if near 0.95."""

    xy: float
    """By the position alone."""
    pose: float
    """By position and heading together."""


@dataclass(frozen=True, slots=True)
class LocalizeResult:
    """All rows and the summary that ``--json`` prints."""

    log: str
    map: str
    seed: int
    rows: list[LocalizeRow]

    @property
    def lost_share(self) -> float | None:
        """Share of the scans whose estimate is lost; None if no scan has a reference."""
        if all(row.reference_x is None for row in self.rows):
            return None
        return sum(row.is_lost for row in self.rows) / len(self.rows)

    @property
    def summary(self) -> dict[str, object]:
        """The ``--json`` object; statistics without a reference are null."""
        rows, coverage = self.rows, self.coverage()
        update_ms = np.array([row.update_ms for row in rows])
        return {
            "log": self.log,
            "map": self.map,
            "seed": self.seed,
            "scans": len(rows),
            "lost_share": self.lost_share,
            "position_m": _error_statistics(row.position_error_m for row in rows),
            "heading_deg": _error_statistics(row.heading_error_deg for row in rows),
            "inside_95": None if coverage is None else dataclasses.asdict(coverage),
            "health_share": {
                str(health): sum(row.health == health for row in rows) / len(rows)
                for health in Health
            },
            "update_ms": {
                "median": float(np.median(update_ms)),
                "p95": float(np.percentile(update_ms, 95)),
            },
            "updates_per_s": 1e3 * len(rows) / float(update_ms.sum()),
            "particles": {"median": float(np.median([row.particles for row in rows]))},
            "peak_memory_mb": _peak_memory_mb(),
        }

    def coverage(self) -> Coverage | None:
        """Return the shares of references inside the 95 % ellipses; None without references."""
        known = [(row.away, row.covariance) for row in self.rows if row.away is not None]
        if not known:
            return None
        away = np.array([pair[0] for pair in known])
        covariance = np.array([pair[1] for pair in known])
        return Coverage(
            xy=float(np.mean(_mahalanobis(away[:, :2], covariance[:, :2, :2]) < CHI_SQUARE_2)),
            pose=float(np.mean(_mahalanobis(away, covariance) < CHI_SQUARE_3)),
        )

    def write_csv(self, path: Path) -> None:
        """Write a heading and one line per scan."""
        with whole_file(path) as part, part.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(LocalizeRow.__dataclass_fields__)
            for row in self.rows:
                writer.writerow(
                    csv_cells("" if value is None else value for value in dataclasses.astuple(row))
                )


def _mahalanobis(away: NDArray[np.float64], covariance: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (n,) squared Mahalanobis distances of away (n, d) by covariances (n, d, d)."""
    solved = np.linalg.solve(covariance, away[:, :, np.newaxis])[:, :, 0]
    distances: NDArray[np.float64] = np.einsum("nd,nd->n", away, solved)
    return distances


def _error_statistics(errors: Iterable[float | None]) -> dict[str, float | None]:
    known = np.array([error for error in errors if error is not None])
    if known.size == 0:
        return dict.fromkeys(("median", "mean", "rmse", "p95", "max"))
    return {
        "median": float(np.median(known)),
        "mean": float(known.mean()),
        "rmse": float(np.sqrt(np.mean(known**2))),
        "p95": float(np.percentile(known, 95)),
        "max": float(known.max()),
    }


def _peak_memory_mb() -> float:
    """Return the process's peak resident memory, MB."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1024.0**2 if sys.platform == "darwin" else 1024.0)
