"""Comparison of an agent's effects with those recorded.

A recording of this layout is compared effect by effect, byte by byte. One of an earlier layout is
compared in every byte to the devices and in every payload's recorded fields; texts for people are
left out, as they may have changed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import msgspec

from robot_agent.messages.effects import Effect, Publish
from robot_agent.messages.streams import modernized
from robot_agent.recording.run_header import SCHEMA_VERSION

_TEXTS = "event"
_TEXT_FIELDS = ("health", "degraded")
_CHANGED_MEANING = ("degrees", "winner", "runner_up", "blocked")
"""Under an override these fields hold the paper's choice, and one override; in earlier layouts
the result of the override, and every override."""


def same_effects(
    recorded: Sequence[Effect], now: Sequence[Effect], layout: int, *, complete: bool
) -> bool:
    """Whether the effects of one event agree with those recorded in a layout.

    complete: False if the recorded ones may be cut off.
    """
    if layout < SCHEMA_VERSION:
        recorded, now = _without_texts(recorded), _without_texts(now)
    if len(now) < len(recorded) or (complete and len(now) > len(recorded)):
        return False
    return all(_same(a, b, layout) for a, b in zip(recorded, now, strict=False))


def _without_texts(effects: Sequence[Effect]) -> list[Effect]:
    return [
        effect
        for effect in effects
        if not (isinstance(effect, Publish) and effect.stream == _TEXTS)
    ]


def _same(recorded: Effect, now: Effect, layout: int) -> bool:
    if (
        layout < SCHEMA_VERSION
        and isinstance(recorded, Publish)
        and isinstance(now, Publish)
        and recorded.stream == now.stream
    ):
        return _same_payload(recorded.stream, recorded.payload, now.payload)
    return recorded == now


def _same_payload(stream: str, recorded: bytes, now: bytes) -> bool:
    """Compare two payloads (JSON) in the fields of the older one."""
    try:
        old: dict[str, Any] = msgspec.json.decode(modernized(stream, recorded), type=dict[str, Any])
    except (msgspec.DecodeError, RecursionError):
        return False  # no agent of ours wrote it
    new: dict[str, Any] = msgspec.json.decode(now)
    changed = _CHANGED_MEANING if "override" in new else ()
    texts = _TEXT_FIELDS if stream == "status" else ()
    return all(
        _agrees(value, new.get(key)) for key, value in old.items() if key not in (*changed, *texts)
    )


def _agrees(old: Any, new: Any) -> bool:
    """Whether a value has the fields of the older one, at any depth, and equals it there."""
    if isinstance(old, dict) and isinstance(new, dict):
        return all(_agrees(value, new.get(key)) for key, value in old.items())
    return bool(old == new)
