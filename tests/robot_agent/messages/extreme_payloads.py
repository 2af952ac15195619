"""Payloads of every stream with an extreme value in every field, made from the streams' types."""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Iterator
from typing import Any

import cv2
import msgspec
import numpy as np
from msgspec import inspect

from robot_agent.messages.streams import STREAMS

DEEP = "deep"
"""Stands for lists nested 100 000 times, which no encoder writes."""
EXTREMES: tuple[Any, ...] = (
    10**309,
    -(10**309),
    2**63,
    2**200,
    1e308,
    -1e308,
    5e-324,
    1e10,
    0,
    -1,
    math.nan,
    math.inf,
    -math.inf,
    "",
    "x" * 100_000,
    "\x1b[2J",
    "=1+1",
    None,
    True,
    [],
    {},
    [0.0] * 30_000,
    {str(number): 0 for number in range(5000)},
    DEEP,
)


def full_value(kind: inspect.Type) -> Any:
    """Return a valid value of a type with every optional field present, as JSON has it."""
    match kind:
        case inspect.Metadata():
            return full_value(kind.type)
        case inspect.StructType():
            return {field.encode_name: full_value(field.type) for field in kind.fields}
        case inspect.UnionType():
            return full_value(kind.types[0])
        case inspect.ListType():
            return [full_value(kind.item_type)]
        case inspect.DictType():
            return {"keep_going": full_value(kind.value_type)}
        case inspect.FloatType():
            return 0.5
        case inspect.IntType():
            return 1
        case inspect.BoolType():
            return True
        case inspect.StrType():
            return "word"
    raise TypeError(kind)


def full_payload(stream: str) -> Any:
    """Return a valid payload of a stream with every field present, as JSON has it."""
    value = full_value(inspect.type_info(STREAMS[stream].payload))
    if "picture" in value:
        _, jpeg = cv2.imencode(".jpg", np.zeros((8, 8, 3), dtype=np.uint8))
        value["picture"] = base64.b64encode(jpeg.tobytes()).decode()
    return value


def with_extreme(value: Any, extreme: Any) -> Iterator[Any]:
    """Yield a value once for each of its parts, at any depth, with that part made extreme."""
    yield extreme
    if isinstance(value, dict):
        for key, part in value.items():
            yield from ({**value, key: changed} for changed in with_extreme(part, extreme))
    elif isinstance(value, list):
        for place, part in enumerate(value):
            for changed in with_extreme(part, extreme):
                yield [*value[:place], changed, *value[place + 1 :]]


def extreme_payloads(stream: str) -> Iterator[bytes]:
    """Yield payloads of a stream: each field in turn with each extreme value."""
    whole = full_payload(stream)
    for extreme in EXTREMES:
        for changed in with_extreme(whole, extreme):
            text = json.dumps(changed).encode()
            yield text.replace(b'"deep"', b"[" * 100_000 + b"]" * 100_000)
    deep = b'"unknown":' + b"[" * 100_000
    yield msgspec.json.encode(whole)[:-1] + b"," + deep
