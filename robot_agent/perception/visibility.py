"""Range within which the patrol takes teammates into account."""

from __future__ import annotations

VISIBILITY = 2.5  # m; the paper's visibility range (section III)
VISIBILITY_MARGIN = 0.1  # m; hysteresis of that range for a teammate in it
