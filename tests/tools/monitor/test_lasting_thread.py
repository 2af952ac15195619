from __future__ import annotations

import pytest

from tools.monitor.lasting_thread import LastingThread
from tools.monitor.monitor import while_sound


def test_end_by_an_error_is_raised_where_the_thread_is_watched() -> None:
    def fail() -> None:
        raise OverflowError("too large")

    thread = LastingThread(fail, "page's server")
    thread.join()
    with pytest.raises(RuntimeError, match="page's server has ended") as raised:
        while_sound(lambda: True, thread.check)()
    assert isinstance(raised.value.__cause__, OverflowError)


def test_end_in_order_is_no_error() -> None:
    thread = LastingThread(lambda: None, "clock")
    thread.join()
    assert while_sound(lambda: True, thread.check)()
