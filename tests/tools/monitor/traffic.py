"""Counts the frames on the laptop's bridge; run inside its namespace, prints JSON on SIGTERM.

Bytes of IP packets by source and destination; other frames by their type.
"""

from __future__ import annotations

import json
import signal
import socket
import struct
import sys
from collections import Counter

ALL_PROTOCOLS, IPV4 = 0x0003, 0x0800


def main() -> None:
    counted: Counter[str] = Counter()
    listening = True

    def end(_number: int, _frame: object) -> None:
        nonlocal listening
        listening = False

    signal.signal(signal.SIGTERM, end)
    port = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ALL_PROTOCOLS))
    port.settimeout(0.1)
    sys.stdout.write("listening\n")
    sys.stdout.flush()
    while listening:
        try:
            frame, (interface, *_) = port.recvfrom(65536)
        except TimeoutError:
            continue
        (kind,) = struct.unpack_from(">H", frame, 12)
        if kind == IPV4 and interface != "lo":
            source, target = (socket.inet_ntoa(frame[at : at + 4]) for at in (26, 30))
            counted[f"{source} {target}"] += len(frame)
        elif kind != IPV4:
            counted[f"type {kind:#06x}"] += len(frame)
    json.dump(counted, sys.stdout)


if __name__ == "__main__":
    main()
