"""Who may read a private key: whoever reads it can report in its owner's name."""

from __future__ import annotations

import stat
from pathlib import Path

KEY = "key.pem"


def rights_trouble(keys: Path) -> str:
    """Return that others may read the key in a folder of ``patrol keys``, with the remedy.

    Empty if only its owner may, or if there is none.
    """
    path = keys / KEY
    try:
        mode = path.stat().st_mode
    except OSError:
        return ""  # told where the key is used
    if not mode & (stat.S_IRGRP | stat.S_IROTH):
        return ""
    return (
        f"{path}: other users of this computer may read this private key ({mode & 0o777:o}): "
        f"`chmod 600 {path}`, and make new keys if they may have"
    )
