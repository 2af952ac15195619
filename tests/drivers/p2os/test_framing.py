from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.p2os.framing import (
    CONTROLLER_MAX_COUNT,
    MAX_COUNT,
    PacketFramer,
    checksum,
    encode_packet,
)

VECTORS = {
    "SYNC0": "FA FB 03 00 00 00",
    "SYNC1": "FA FB 03 01 00 01",
    "SYNC2": "FA FB 03 02 00 02",
    "OPEN 1": "FA FB 06 01 3B 01 00 02 3B",
    "ENABLE 1": "FA FB 06 04 3B 01 00 05 3B",
    "ENABLE 0": "FA FB 06 04 3B 00 00 04 3B",
    "SETA +300": "FA FB 06 05 3B 2C 01 31 3C",
    "SETA -300": "FA FB 06 05 1B 2C 01 31 1C",
    "SETV 400": "FA FB 06 06 3B 90 01 96 3C",
    "SETO": "FA FB 03 07 00 07",
    "VEL +300": "FA FB 06 0B 3B 2C 01 37 3C",
    "VEL -300": "FA FB 06 0B 1B 2C 01 37 1C",
    "HEAD 90": "FA FB 06 0C 3B 5A 00 66 3B",
    "SAY": "FA FB 09 0F 2B 04 01 06 02 69 19 47",
    "CONFIG 1": "FA FB 06 12 3B 01 00 13 3B",
    "ENCODER 2": "FA FB 06 13 3B 02 00 15 3B",
    "RVEL +20": "FA FB 06 15 3B 14 00 29 3B",
    "RVEL -20": "FA FB 06 15 1B 14 00 29 1B",
    "SETRA 100": "FA FB 06 17 3B 64 00 7B 3B",
    "SONAR 0": "FA FB 06 1C 3B 00 00 1C 3B",
    "SONAR 1": "FA FB 06 1C 3B 01 00 1D 3B",
    "STOP": "FA FB 03 1D 00 1D",
    "DIGOUT": "FA FB 06 1E 1B 19 09 37 24",
    "VEL2 +10 +10": "FA FB 06 20 3B 0A 0A 2A 45",
    "VEL2 -5 +5 raw": "FA FB 06 20 3B 05 FB 26 36",
    "IOREQUEST 2": "FA FB 06 28 3B 02 00 2A 3B",
    "BUMP_STALL 3": "FA FB 06 2C 3B 03 00 2F 3B",
    "HOSTBAUD 2": "FA FB 06 32 3B 02 00 34 3B",
    "E_STOP": "FA FB 03 37 00 37",
    "POLLING": "FA FB 09 03 2B 04 01 02 01 02 09 2F",
    "POLLING with NUL": "FA FB 0A 03 2B 04 01 02 01 02 00 0B 2D",
    "SYNC2 reply": "FA FB 18 02 4D 79 52 6F 62 6F 74 00 50 69 6F 6E 65 65 72 00 70 32 64 78 00"
    " 42 DF",
    "SIP moving": "FA FB 21 33 E8 03 BC 7F 00 04 C8 00 38 FF 7F 00 00 00 00 03 00 00 02 00 93 0E"
    " 08 E1 48 05 00 00 FF 00 B4 07",
    "SIP idle": "FA FB 1B 32 00 00 00 00 00 00 00 00 00 00 80 00 00 00 00 00 00 00 00 05 00 00 FF"
    " 00 38 7F",
    "SIP stalled": "FA FB 1B 32 00 00 00 00 00 00 00 00 00 00 80 09 22 00 00 01 00 00 00 05 00 00"
    " FF 00 42 A1",
    "ENCODER": "FA FB 0B 90 E8 03 00 00 18 FC FF FF 90 00",
    "SERAUX": "FA FB 06 B0 90 50 00 00 90",
    "GYRO": "FA FB 07 98 01 08 02 1E A0 1D",
    "IO": "FA FB 0B F0 02 FF 00 01 00 01 00 04 F1 06",
    "CONFIG": "FA FB 56 20 50 69 6F 6E 65 65 72 00 70 32 64 78 00 53 49 4D 30 30 30 31 00 00 68 01"
    " E8 03 2C 01 D0 07 F4 01 73 69 6D 00 64 00 00 00 00 01 00 01 6E 00 BA 40 D0 07 00 C8 00 64 00"
    " F4 01 32 00 64 00 90 01 64 00 64 00 14 00 14 00 00 00 2C 01 2C 01 14 00 14 00 00 00 85 93",
}
PACKETS = [pytest.param(bytes.fromhex(text), id=name) for name, text in VECTORS.items()]
GARBAGE = [b"", b"WMS2\r", b"\xfa", b"\xfa\xfa", b"\xfb\xfa\x00", b"\xfa\xfb\x00", b"\xfa\xfb\x02"]


def feed_singly(framer: PacketFramer, stream: bytes) -> list[bytes]:
    return [packet for byte in stream for packet in framer.feed(bytes((byte,)))]


@pytest.mark.parametrize("packet", PACKETS)
def test_vector_is_encoded(packet: bytes) -> None:
    assert encode_packet(packet[3:-2]) == packet


@pytest.mark.parametrize("packet", PACKETS)
@pytest.mark.parametrize("before", GARBAGE)
def test_vector_is_found_in_noise(packet: bytes, before: bytes) -> None:
    stream = before + packet + b"\x00\xfb\xfa"
    whole, single = PacketFramer(), PacketFramer()
    assert whole.feed(stream) == [packet[3:-2]]
    assert feed_singly(single, stream) == [packet[3:-2]]
    assert whole.counters == single.counters
    assert whole.counters.good == 1
    assert whole.counters.bad_checksum == 0
    assert whole.counters.discarded_bytes == len(before) + 2
    assert whole.pending == 1


@pytest.mark.parametrize("packet", PACKETS)
def test_two_packets_in_one_read_are_found(packet: bytes) -> None:
    framer = PacketFramer()
    assert framer.feed(packet + packet) == [packet[3:-2]] * 2
    assert framer.pending == 0


@pytest.mark.parametrize("packet", PACKETS)
def test_bad_checksum_is_counted_and_the_next_packet_found(packet: bytes) -> None:
    framer = PacketFramer()
    broken = packet[:-1] + bytes((packet[-1] ^ 0x01,))
    stop = bytes.fromhex(VECTORS["STOP"])
    assert framer.feed(broken + stop) == [stop[3:-2]]
    assert framer.counters.bad_checksum == 1
    assert framer.counters.discarded_bytes == len(broken)


def test_search_resumes_inside_a_false_packet() -> None:
    stop = bytes.fromhex(VECTORS["STOP"])
    framer = PacketFramer()
    assert framer.feed(b"\xfa\xfb\x0a" + stop) == []
    assert framer.feed(stop) == [stop[3:-2]] * 2
    assert framer.counters.bad_checksum == 1


def test_lost_byte_costs_one_packet() -> None:
    sip = bytes.fromhex(VECTORS["SIP moving"])
    framer = PacketFramer()
    assert framer.feed(sip[:9] + sip[10:]) == []
    assert framer.feed(sip + sip) == [sip[3:-2]] * 2


def test_abandoned_packet_returns_packets_behind_its_header() -> None:
    stop = bytes.fromhex(VECTORS["STOP"])
    framer = PacketFramer()
    assert framer.feed(b"\xfa\xfb\xf0" + stop) == []
    assert framer.abandon_packet() == [stop[3:-2]]
    assert framer.abandon_packet() == []
    assert framer.counters.discarded_bytes == 3


def test_controller_drops_counts_over_200() -> None:
    long_packet = encode_packet(bytes(199))
    assert PacketFramer(CONTROLLER_MAX_COUNT).feed(long_packet) == []
    assert PacketFramer().feed(long_packet) == [bytes(199)]


@pytest.mark.parametrize("size", [0, MAX_COUNT - 1])
def test_data_of_invalid_length_is_refused(size: int) -> None:
    with pytest.raises(ValueError, match="1 to 253"):
        encode_packet(bytes(size))


def test_checksum_wraps_at_16_bits() -> None:
    assert checksum(b"\xff\xff\x00\x02") == 0x0001
    assert checksum(b"\xff\xff\x00\x02\x80") == 0x0081


@given(st.lists(st.binary(min_size=1, max_size=253), max_size=5))
def test_packets_round_trip(data: list[bytes]) -> None:
    framer = PacketFramer()
    assert framer.feed(b"".join(encode_packet(one) for one in data)) == data
    assert framer.counters.discarded_bytes == 0


@given(
    st.lists(
        st.one_of(
            st.binary(max_size=40),
            st.sampled_from([*map(bytes.fromhex, VECTORS.values()), b"\xfa\xfb"]),
        ),
        max_size=12,
    )
)
def test_any_stream_gives_the_same_packets_in_any_pieces(pieces: list[bytes]) -> None:
    whole, by_piece, single = PacketFramer(), PacketFramer(), PacketFramer()
    stream = b"".join(pieces)
    packets = whole.feed(stream)
    assert [packet for piece in pieces for packet in by_piece.feed(piece)] == packets
    assert feed_singly(single, stream) == packets
    assert whole.counters == by_piece.counters == single.counters
    assert whole.pending == by_piece.pending == single.pending < MAX_COUNT + 3
    framed = sum(len(packet) + 5 for packet in packets)
    assert whole.counters.discarded_bytes + framed + whole.pending == len(stream)


@given(st.data())
def test_mutated_traffic_never_raises_and_untouched_packets_survive(data: st.DataObject) -> None:
    sip = bytes.fromhex(VECTORS["SIP moving"])
    stream = bytearray(sip * 3)
    at = data.draw(st.integers(len(sip), 2 * len(sip) - 1))
    stream[at] = data.draw(st.integers(0, 255).filter(lambda value: value != sip[at - len(sip)]))
    framer = PacketFramer()
    packets = framer.feed(bytes(stream))
    assert packets[0] == sip[3:-2]
    # A count made larger may swallow the next packet until enough bytes have come.
    packets += framer.feed(sip * 8)
    assert packets.count(sip[3:-2]) >= 10
