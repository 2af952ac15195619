"""Types of the payloads' fields: each is bounded, so that no reader overflows or fills its memory.

A payload out of bounds is refused as a whole when it is decoded.
"""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from maps.input_limits import MAX_COUNT, MAX_NUMBER, MAX_TEXT, MAX_WORD

Number = Annotated[float, Meta(ge=-MAX_NUMBER, le=MAX_NUMBER)]
Count = Annotated[int, Meta(ge=0, le=MAX_COUNT)]
Word = Annotated[str, Meta(max_length=MAX_WORD)]
Text = Annotated[str, Meta(max_length=MAX_TEXT)]
