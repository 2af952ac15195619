"""The outbox: everything an event brings about, in order, once."""

from drivers.requests import SetBaud, Write
from robot_agent.messages.effects import ChangeBaud, Publish, Send, TakePicture
from robot_agent.messages.foxglove import Log, timestamp_at
from robot_agent.messages.log_level import LogLevel
from robot_agent.messages.notice import Notice
from robot_agent.messages.outbox import Outbox


def test_items_come_out_in_their_order_and_only_once():
    outbox = Outbox()
    notice = Notice(1.0, "gate", "holds", LogLevel.WARNING)
    outbox.add(TakePicture(), notice)
    outbox.request("laser", [Write(b"\x02"), SetBaud(38400)])
    log = Log(timestamp=timestamp_at(1.0), level=2, message="x", name="y")
    outbox.publish([("event", log)])
    items = outbox.pop_all()
    assert items[:4] == [TakePicture(), notice, Send("laser", b"\x02"), ChangeBaud("laser", 38400)]
    assert isinstance(items[4], Publish)
    assert items[4].stream == "event"
    assert outbox.pop_all() == []
