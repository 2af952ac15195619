"""Runs commands on hostile files in one process; prints one JSON line per command.

Usage: python -m tests.tools.hostile_files GROUP FOLDER. Each line holds name, exit status, what
was printed, processor time (s), and the process's peak memory so far (MB).
"""

from __future__ import annotations

import gzip
import io
import json
import math
import resource
import struct
import sys
import zlib
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import zstandard
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC

from tests.tools.monitor.agent_recordings import START, agent_recording
from tools.cli import main

YAML = """image: {image}
resolution: 0.05
origin: [0.0, 0.0, 0.0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
"""
PGM = b"P5\n40 40\n255\n" + bytes([254]) * 1600
MB = 1024 * 1024


def aliases() -> str:
    first = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]"
    rest = (f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 10)}]" for n in range(1, 12))
    return "\n".join([first, *rest])


def png(width: int, height: int) -> bytes:
    def chunk(kind: bytes, body: bytes) -> bytes:
        return (
            struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        )

    pixels = zlib.compress(bytes(32 * MB))
    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    end = chunk(b"IDAT", pixels) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + end


def vertices(count: int, radius: float) -> str:
    places = (
        (radius * math.cos(n * math.tau / count), radius * math.sin(n * math.tau / count))
        for n in range(count)
    )
    words = ", ".join(f"[{x:.6f}, {y:.6f}]" for x, y in places)
    return f"closed = true\ncorner_radius = 0.6\nvertices = [{words}]\n"


def map_folders(folder: Path) -> Iterator[tuple[str, list[str]]]:
    """Write map folders; yield names and commands."""
    plain = YAML.format(image="map.pgm")
    big = b"P5\n32000 32000\n255\n" + bytes(1000)
    square = (
        "closed = true\ncorner_radius = 1.0\nvertices = [[0, 0], [{0}, 0], [{0}, {0}], [0, {0}]]"
    )
    cases: dict[str, tuple[str | bytes, bytes, str | bytes]] = {
        "aliases": (aliases() + "\n" + plain.replace("map.pgm", "*a11"), PGM, ""),
        "one alias": (plain + "b: &b x\nc: *b\n", PGM, ""),
        "nested yaml": (plain + "deep: " + "[" * 100_000, PGM, ""),
        "nested mappings": (plain + "deep: " + "{a: " * 100_000, PGM, ""),
        "400 digits": (plain.replace("0.05", "1" * 400), PGM, ""),
        "5000 digits": (plain.replace("0.05", "1" * 5000), PGM, ""),
        "long text": (plain.replace("map.pgm", "m" * 900_000), PGM, ""),
        "huge yaml": (plain + "# " + "x" * 5 * MB, PGM, ""),
        "huge pgm": (plain, big, ""),
        "huge png": (YAML.format(image="map.png"), png(32_000, 32_000), ""),
        "wide png": (YAML.format(image="map.png"), png(2**31 - 1, 2**31 - 1), ""),
        "far border": (plain, PGM, square.format("1e9")),
        "long border": (plain, PGM, square.format("99999.0")),
        "long arcs": (
            plain,
            PGM,
            square.format("99999.0").replace("corner_radius = 1.0", "corner_radius = 4e4"),
        ),
        "many vertices": (plain, PGM, vertices(20_000, 90_000.0)),
        "nested toml": (plain, PGM, "x = " + "[" * 100_000),
        "digits in toml": (
            plain,
            PGM,
            f"closed = true\ncorner_radius = {'1' * 400}\nvertices = []",
        ),
        "more digits in toml": (plain, PGM, f"closed = true\ncorner_radius = {'1' * 5000}"),
    }
    for name, (yaml, image, border) in cases.items():
        place = folder / name.replace(" ", "_")
        place.mkdir()
        (place / "map.yaml").write_text(str(yaml))
        (place / ("map.png" if image.startswith(b"\x89") else "map.pgm")).write_bytes(image)
        if border:
            (place / "border.toml").write_text(str(border))
        yield name, ["map", "check", str(place)]


def robot_laser(t: float, beams: int, increment: float, x: float = 0.0) -> str:
    ranges = " ".join(f"{2.0 + 0.01 * k:.2f}" for k in range(beams))
    return (
        f"ROBOTLASER1 0 -1.5 3.0 {increment} 80.0 0.01 0 {beams} {ranges} 0 "
        f"{x} 0 0 {x} 0 0 0.1 0 0 0 0 {t} host {t}"
    )


def logs(folder: Path) -> Iterator[tuple[str, list[str]]]:
    """Write CARMEN logs, captures and relations; yield names and commands."""
    step = math.pi / 180
    contents = {
        "gzip bomb": gzip.compress(bytes(600 * MB), 1),
        "nested gzip members": gzip.compress(bytes(60 * MB), 1) * 10,
        "three beams": "\n".join(robot_laser(0.2 * n, 3, 1.5) for n in range(9)).encode(),
        "endless turn, by its field of view": robot_laser(0.0, 181, 1e9).encode() + b"\n",
        "no angle, by its field of view": robot_laser(0.0, 181, 0.0).encode() + b"\n",
        "jump ahead, taken to go on": (
            f"{robot_laser(0, 181, step)}\n{robot_laser(1e9, 181, step)}\n".encode()
        ),
        "many pauses": "".join(
            f"{robot_laser(3500.0 * n, 181, step)}\n" for n in range(300)
        ).encode(),
        "huge time, its line left out": (
            f"{robot_laser(0, 181, step)}\n{robot_laser(1e300, 181, step)}\n".encode()
        ),
        "huge place": f"{robot_laser(0, 181, step, 1e300)}\n".encode(),
        "400 digits in a log": f"ODOM {'1' * 400} 0 0 0 0 0 0 host 0\n".encode(),
        "5000 beams' digits": f"FLASER {'1' * 5000} 1 2 3\n".encode(),
    }
    for name, content in contents.items():
        path = folder / f"{name.replace(' ', '_')}.log"
        path.write_bytes(content)
        target = str(folder / "converted.mcap")
        yield name, ["convert", str(path), "-o", target, "--map", "paper_lab"]
    captures = {
        "capture that jumps": (
            '{"t": 0, "dir": "robot->host", "hex": "fafb"}\n'
            '{"t": 1e12, "dir": "robot->host", "hex": "fafb"}\n'
        ),
        "nested capture": '{"t": 0, "dir": "robot->host", "hex": "fafb", "x": ' + "[" * 100_000,
        "digits in a capture": f'{{"t": {"1" * 400}, "dir": "robot->host", "hex": "fafb"}}\n',
    }
    for name, text in captures.items():
        path = folder / f"{name.replace(' ', '_')}.jsonl"
        path.write_text(text)
        yield name, ["convert", str(path), "-o", str(folder / "converted.mcap")]


def record(opcode: int, body: bytes) -> bytes:
    return struct.pack("<BQ", opcode, len(body)) + body


def chunk(compression: str, data: bytes, size: int) -> bytes:
    word = compression.encode()
    head = struct.pack("<QQQII", 1, 2, size, 0, len(word)) + word
    return record(Opcode.CHUNK, head + struct.pack("<Q", len(data)) + data)


def zstd_bomb(mega: int) -> bytes:
    compressor = zstandard.ZstdCompressor().compressobj()
    block = bytes(MB)
    return b"".join(compressor.compress(block) for _ in range(mega)) + compressor.flush()


def lz4_bomb(mega: int) -> bytes:
    import lz4.frame

    with lz4.frame.LZ4FrameCompressor() as compressor:
        block = bytes(MB)
        parts = [compressor.begin(), *(compressor.compress(block) for _ in range(mega))]
        return b"".join(parts) + compressor.flush()


def recordings(folder: Path) -> Iterator[tuple[str, list[str]]]:
    """Write recordings with a hostile record after their head; yield names and commands."""
    whole = agent_recording("anna", folder / "whole.mcap", START, 10.0).read_bytes()
    offset = len(MCAP0_MAGIC)
    while whole[offset] != Opcode.CHUNK:
        offset += 9 + struct.unpack_from("<Q", whole, offset + 1)[0]
    bombs = {
        "zstd bomb": chunk("zstd", zstd_bomb(768), 1000),
        "zstd bomb that claims much": chunk("zstd", zstd_bomb(768), 2**40),
        "lz4 bomb": chunk("lz4", lz4_bomb(768), 1000),
        "unknown compression": chunk("brotli", b"x" * 100, 1000),
        "undefined channels": chunk("", b"", 0)
        + b"".join(record(Opcode.MESSAGE_INDEX, struct.pack("<HI", n, 0)) for n in range(20_000)),
        "clock that jumps": chunk(
            "", record(Opcode.MESSAGE, struct.pack("<HIQQ", 1, 0, 2**63, 0) + b"{}"), 33
        ),
    }
    for name, bomb in bombs.items():
        path = folder / f"{name.replace(' ', '_')}.mcap"
        path.write_bytes(whole[:offset] + bomb + whole[offset:])
        yield f"{name}, report", ["report", str(path), "-o", str(folder / "report")]
        yield f"{name}, replay", ["replay", str(path)]
        yield (
            f"{name}, monitor",
            [
                *("monitor", "--text", "--duration", "0.3", "--play", str(path)),
            ],
        )


def texts(folder: Path) -> Iterator[tuple[str, list[str]]]:
    """Write configurations and floor plans; yield names and commands."""
    for name, text in {
        "nested configuration": "x = " + "[" * 100_000,
        "digits in a configuration": f"[patrol]\nspeed = {'1' * 5000}\n",
        "huge configuration": "# " + "x" * 5 * MB,
    }.items():
        path = folder / f"{name.replace(' ', '_')}.toml"
        path.write_text(text)
        yield name, ["agent", str(path)]
    plan = folder / "plan.toml"
    plan.write_text(
        "resolution = 1e-6\norigin = [0, 0]\nsize = [1e6, 1e6]\nwall_thickness = 0.1\n"
        "floor = [[0, 0], [1, 0], [1, 1]]\n"
    )
    yield "huge floor plan", ["map", "draw", str(plan), "-o", str(folder / "drawn")]


def peak_mb() -> int:
    """Return this program's peak memory, MB; getrusage would give that of the starter's as well."""
    status = Path("/proc/self/status").read_text()
    return int(status.partition("VmHWM:")[2].split()[0]) // 1024


GROUPS = {each.__name__: each for each in (map_folders, logs, recordings, texts)}


def run(group: str, folder: Path) -> None:
    for name, command in list(GROUPS[group](folder)):
        before = resource.getrusage(resource.RUSAGE_SELF)
        told = io.StringIO()
        with redirect_stderr(told), redirect_stdout(told):
            try:
                status: int | str = main(command)
            except Exception as error:  # noqa: BLE001 - what must not happen is told
                status = f"{type(error).__name__}: {error}"[:300]
        after = resource.getrusage(resource.RUSAGE_SELF)
        row = {
            "name": name,
            "status": status,
            "told": told.getvalue(),
            "seconds": round(after.ru_utime - before.ru_utime, 2),
            "memory_mb": peak_mb(),
        }
        sys.stdout.write(json.dumps(row) + "\n")


if __name__ == "__main__":
    run(sys.argv[1], Path(sys.argv[2]))
