"""``patrol campaign``: an alias of ``patrol faults``, kept for its former name."""

from __future__ import annotations

from tools.commands.faults import configure, run

__all__ = ["configure", "run"]
