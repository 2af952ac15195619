from __future__ import annotations

import pytest

from robot_agent.messages.effects import Publish
from robot_agent.messages.streams import STREAMS
from tests.robot_agent.messages.extreme_payloads import extreme_payloads
from tools.replay.comparison import same_effects


@pytest.mark.parametrize("stream", sorted(set(STREAMS) - {"event", "process_log"}))
def test_extreme_payload_of_an_earlier_layout_is_a_difference(stream: str) -> None:
    now = [Publish(stream, b'{"timestamp":7}')]
    for data in extreme_payloads(stream):
        if len(data) > 2:
            assert not same_effects([Publish(stream, data)], now, 1, complete=True)
