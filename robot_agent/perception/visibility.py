"""How near a teammate must be for the patrol to count it."""

from __future__ import annotations

VISIBILITY = 2.5  # m; the paper's visibility range (section III)
VISIBILITY_MARGIN = 0.1  # m; a teammate that counts already is kept this much farther
