"""``patrol campaign``: the same as ``patrol faults``, which it was called first."""

from __future__ import annotations

from tools.commands.faults import configure, run

__all__ = ["configure", "run"]
