"""The clock jumps while robot and monitor are linked by TLS."""

from __future__ import annotations

import pytest

from tools.campaign.clock_jumps import EXPIRED, _require_link_kept, _require_new_link, jump_clocks
from tools.campaign.clock_party import Seen
from tools.campaign.endurance import EnduranceError
from tools.campaign.set_clock import faketime_library

EXPIRY = "ca.pem was valid until 2036, and this computer's clock says 2046: set the clock"


@pytest.mark.skipif(faketime_library() is None, reason="faketime is not there")
def test_link_survives_and_is_made_again_and_expiry_is_said() -> None:
    (held,) = jump_clocks(1)
    assert held.handles > 0


@pytest.mark.long
@pytest.mark.skipif(faketime_library() is None, reason="faketime is not there")
def test_many_jumps_leave_nothing_behind() -> None:
    held = list(jump_clocks(20))
    assert held[-1].memory_mb - held[4].memory_mb < 4.0
    assert abs(held[-1].handles - held[4].handles) <= 3


def seen(*, heard: bool, failed: str = "", told: str = "") -> Seen:
    return Seen(2046, heard, failed, [told] if told else [], 20, 10, 100.0)


def test_lost_link_and_silence_about_expiry_are_trouble() -> None:
    _require_link_kept(seen(heard=True, told=EXPIRY), EXPIRED)
    with pytest.raises(EnduranceError, match="the link was lost"):
        _require_link_kept(seen(heard=False, told=EXPIRY), EXPIRED)
    with pytest.raises(EnduranceError, match="the monitor tells"):
        _require_link_kept(seen(heard=True), EXPIRED)


def test_link_with_expired_certificates_is_trouble() -> None:
    _require_new_link(seen(heard=False, failed=EXPIRY), EXPIRED)
    with pytest.raises(EnduranceError, match="a new link was made"):
        _require_new_link(seen(heard=True, failed=EXPIRY), EXPIRED)
    with pytest.raises(EnduranceError, match="the robot tells"):
        _require_new_link(seen(heard=False), EXPIRED)
