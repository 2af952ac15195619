"""``Border.nearest`` and ``Border.at`` for many positions at once, with the same branches."""

from __future__ import annotations

import math

import numpy as np

from maps.border import BRANCH_MARGIN, BRANCH_REACH, CELL, Border
from maps.border_foot import SegmentFoot
from tools.batch.arrays import Flags, Indices, Reals

_ROOM = 8.0  # m round the border within which positions are looked up
_UNKNOWN = -1


class BorderFeet:
    """Projects positions (n,) on a border; which pieces are near is looked up by cell."""

    def __init__(self, border: Border) -> None:
        self._border = border
        self.length, self.closed = border.length, border.closed
        self._starts = np.array(border.starts)
        self._straight = np.array([isinstance(foot, SegmentFoot) for foot in border.feet])
        rows = [_row(foot) for foot in border.feet]
        self._parameters = np.ascontiguousarray(np.array(rows).T)
        low = np.floor((border.polyline(CELL).min(axis=0) - _ROOM) / CELL)
        high = np.floor((border.polyline(CELL).max(axis=0) + _ROOM) / CELL)
        self._first = low
        self._cols, self._rows = (high - low + 1.0).astype(int).tolist()
        cells = self._rows * self._cols
        self._count = np.full(cells, _UNKNOWN)
        self._near = np.zeros((1, cells), dtype=np.intp)

    def nearest(self, x: Reals, y: Reals, near: Reals | None = None) -> tuple[Reals, Reals]:
        """Return (distances, abscissae), each (n,) m, as ``Border.nearest`` does for each.

        near: (n,) the abscissae before, m, nan for none.
        """
        cells = self._cells(x, y)
        count = self._count[cells]
        distance, s = self._on_pieces(self._near[0, cells], x, y)
        several = (count > 1).nonzero()[0]
        if several.size:
            hint = None if near is None else near[several]
            first = distance[several], s[several]
            distance[several], s[several] = self._nearest_of(
                cells[several], count[several], x[several], y[several], hint, first
            )
        beyond = s >= self.length
        s[beyond] = 0.0 if self.closed else self.length
        return distance, s

    def at(self, s: Reals) -> tuple[Reals, Reals, Reals, Reals, Reals]:
        """Return (x, y, tangent x, tangent y, curvature), each (n,), at abscissae (n,) m."""
        piece = self._starts.searchsorted(s, side="right") - 1
        x0, y0, tx, ty, _, s0 = self._parameters[:6].take(piece, axis=1)
        along = s - s0
        x, y = x0 + along * tx, y0 + along * ty
        curvature = np.zeros(len(s))
        arcs = (~self._straight[piece]).nonzero()[0]
        if arcs.size:
            p = self._parameters[:8].take(piece[arcs], axis=1)
            cx, cy, radius, turn, _half, middle, s_middle, bend = p
            angle = middle + (s[arcs] - s_middle) * bend
            c, sine = np.cos(angle), np.sin(angle)
            x[arcs], y[arcs] = cx + radius * c, cy + radius * sine
            tx[arcs], ty[arcs] = -turn * sine, turn * c
            curvature[arcs] = bend
        return x, y, tx, ty, curvature

    def difference(self, s_to: Reals, s_from: Reals) -> Reals:
        """Return s_to - s_from along the border, m, wrapped as ``Border.difference`` does."""
        delta = s_to - s_from
        if not self.closed:
            return delta
        half = self.length / 2
        return np.asarray(np.mod(delta + half, self.length) - half)

    def _cells(self, x: Reals, y: Reals) -> Indices:
        col = np.floor(x / CELL) - self._first[0]
        row = np.floor(y / CELL) - self._first[1]
        # Positions farther off have the pieces of the rim; a robot never gets there.
        np.clip(col, 0, self._cols - 1, out=col)
        np.clip(row, 0, self._rows - 1, out=row)
        cells: Indices = (row * self._cols + col).astype(np.intp)
        if (self._count[cells] == _UNKNOWN).any():
            for cell in np.unique(cells[self._count[cells] == _UNKNOWN]).tolist():
                self._look_up(cell)
        return cells

    def _look_up(self, cell: int) -> None:
        """Store the numbers of the pieces that can be nearest to a position in a cell."""
        row, col = divmod(cell, self._cols)
        x, y = ((number + 0.5) * CELL for number in (col + self._first[0], row + self._first[1]))
        feet = self._border.feet_near(x, y)
        numbers = [number for number, foot in enumerate(self._border.feet) if foot in feet]
        while len(self._near) < len(numbers):
            self._near = np.concatenate((self._near, np.zeros((1, self._near.shape[1]), np.intp)))
        self._near[: len(numbers), cell] = numbers
        self._count[cell] = len(numbers)

    def _nearest_of(
        self,
        cells: Indices,
        count: Indices,
        x: Reals,
        y: Reals,
        near: Reals | None,
        first: tuple[Reals, Reals],
    ) -> tuple[Reals, Reals]:
        """Return (distances, abscissae) where several pieces can be nearest.

        first: the same on the first of them.
        """
        best_distance, best_s = first
        kept_distance, kept_s = np.full(len(x), math.inf), np.zeros(len(x))
        for slot in range(int(count.max())):
            if slot:
                distance, s = self._on_pieces(self._near[slot, cells], x, y)
                distance[count <= slot] = math.inf
                nearer = distance < best_distance
                best_distance = np.where(nearer, distance, best_distance)
                best_s = np.where(nearer, s, best_s)
            else:
                distance, s = first
            if near is not None:
                kept = (distance < kept_distance) & self._on_branch(s, near)
                kept_distance = np.where(kept, distance, kept_distance)
                kept_s = np.where(kept, s, kept_s)
        keeps = kept_distance <= best_distance + BRANCH_MARGIN
        return np.where(keeps, kept_distance, best_distance), np.where(keeps, kept_s, best_s)

    def _on_branch(self, s: Reals, near: Reals) -> Flags:
        # nan, for no abscissa before, compares as False.
        return np.asarray(np.abs(self.difference(s, near)) <= BRANCH_REACH)

    def _on_pieces(self, pieces: Indices, x: Reals, y: Reals) -> tuple[Reals, Reals]:
        """Return (distances, abscissae) of the nearest points of one piece each."""
        x0, y0, tx, ty, length, s0 = self._parameters[:6].take(pieces, axis=1)
        dx, dy = x - x0, y - y0
        along = dx * tx + dy * ty
        inside = np.minimum(np.maximum(along, 0.0), length)
        s = s0 + inside
        distance = np.abs(dy * tx - dx * ty)
        out = (inside != along).nonzero()[0]
        if out.size:
            off = inside[out]
            distance[out] = np.hypot(dx[out] - off * tx[out], dy[out] - off * ty[out])
        arcs = (~self._straight[pieces]).nonzero()[0]
        if arcs.size:
            p = self._parameters.take(pieces[arcs], axis=1)
            distance[arcs], s[arcs] = _on_arcs(p, dx[arcs], dy[arcs], x[arcs], y[arcs])
        return distance, s


def _on_arcs(p: Reals, dx: Reals, dy: Reals, x: Reals, y: Reals) -> tuple[Reals, Reals]:
    radius, turn, half, middle, s_middle = p[2:7]
    # The middle of an arc may lie several turns off zero.
    angle = np.arctan2(dy, dx) - middle
    angle -= math.tau * np.rint(angle / math.tau)
    inside = np.minimum(np.maximum(angle, -half), half)
    distance = np.abs(np.hypot(dx, dy) - radius)
    out = (inside != angle).nonzero()[0]
    if out.size:
        end = np.where(angle[out] > 0.0, p[8:10, out], p[10:12, out])
        distance[out] = np.hypot(x[out] - end[0], y[out] - end[1])
    return distance, s_middle + radius * turn * inside


def _row(foot: object) -> list[float]:
    """Return a piece's twelve numbers; those of a segment and of an arc differ in meaning."""
    if isinstance(foot, SegmentFoot):
        return [foot.x0, foot.y0, foot.tx, foot.ty, foot.length, foot.s0, *[0.0] * 6]
    (x0, y0), (x1, y1) = foot.ends  # type: ignore[attr-defined]
    return [
        *(foot.cx, foot.cy, foot.radius, foot.turn, foot.half),  # type: ignore[attr-defined]
        *(foot.middle, foot.s_middle, foot.curvature),  # type: ignore[attr-defined]
        *(x0, y0, x1, y1),
    ]
