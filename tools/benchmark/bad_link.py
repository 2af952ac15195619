"""A TCP proxy that emulates a bad Wi-Fi: it delays every segment and stalls at random.

``python -m tools.benchmark.bad_link LISTEN_PORT TARGET_PORT``, both on loopback. TCP retransmits
lost segments, so a loss shows as a stall: one segment in a hundred is 1 s later still.
"""

from __future__ import annotations

import asyncio
import random
import sys

DELAY_S = 0.5
LOSS = 0.01
STALL_S = 1.0
SEGMENT_BYTES = 1400
SEED = 1
_MAX_WAITING = 200  # segments in flight; then the sender must wait


async def pass_on(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    """Forward one direction with delay and stalls until it ends."""
    rng = random.Random(SEED)  # noqa: S311 - losses, not secrets
    loop = asyncio.get_running_loop()
    waiting: asyncio.Queue[tuple[float, bytes]] = asyncio.Queue(_MAX_WAITING)

    async def deliver() -> None:
        while True:
            due, segment = await waiting.get()
            stall = STALL_S if rng.random() < LOSS else 0.0
            await asyncio.sleep(max(due - loop.time(), 0.0) + stall)
            if not segment:
                break
            writer.write(segment)
            await writer.drain()
        writer.close()

    delivery = asyncio.create_task(deliver())
    try:
        while segment := await reader.read(SEGMENT_BYTES):
            await waiting.put((loop.time() + DELAY_S, segment))
        await waiting.put((loop.time() + DELAY_S, b""))
        await delivery
    except ConnectionError:
        delivery.cancel()
        writer.close()


async def serve(port: int, target: int) -> None:
    """Forward every connection to a port to the target port on loopback, both ways."""

    async def connected(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            onward_reader, onward_writer = await asyncio.open_connection("127.0.0.1", target)
        except OSError:
            writer.close()
            return
        await asyncio.gather(pass_on(reader, onward_writer), pass_on(onward_reader, writer))

    async with await asyncio.start_server(connected, "127.0.0.1", port) as server:
        await server.serve_forever()


if __name__ == "__main__":
    asyncio.run(serve(int(sys.argv[1]), int(sys.argv[2])))
