"""Hashes that tell whether two map folders hold the same map and the same border."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping

HASH_SHOWN = 16
"""Characters of a hash that telemetry carries: two maps never share them by chance."""


def identity(files: Mapping[str, bytes]) -> tuple[str, str]:
    """Return the SHA-256 of a map folder's map and of its border; empty if missing."""
    borders = {name: data for name, data in files.items() if name.endswith(".toml")}
    rest = {name: data for name, data in files.items() if name not in borders}
    return _hash(rest), _hash(borders)


def _hash(files: Mapping[str, bytes]) -> str:
    if not files:
        return ""
    digest = hashlib.sha256()
    for name, data in sorted(files.items()):
        digest.update(f"{name} {len(data)}\n".encode())
        digest.update(data)
    return digest.hexdigest()
