"""``patrol test``: lint, types and every test that needs no hardware."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent

CHECKS = (
    ("ruff", "check", "."),
    ("ruff", "format", "--check", "."),
    ("mypy",),
    ("lint-imports",),
    ("vulture",),
)
"""Programs of the environment; lint-imports checks the import contracts in pyproject.toml, vulture
finds unused code."""
SIDE_BY_SIDE = ("-n", str((os.cpu_count() or 1) + 1), "--dist", "worksteal")
"""One worker more than cores: half of the tests mostly wait for emulated devices in real time. On
2 cores 290 s, with one per core 335 s."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = "example: patrol test --long -- tests/drivers -k fuzzed"
    parser.add_argument("--long", action="store_true", help="also the tests that take minutes")
    parser.add_argument("pytest", nargs="*", help="arguments handed to pytest, after --")


def run(options: argparse.Namespace) -> int:
    """Run all checks, then the tests; return 1 at the first failure, 0 if there is none."""
    chosen = ("-m", "long or not long") if options.long else ()
    for check in (*CHECKS, ("pytest", *SIDE_BY_SIDE, *chosen, *options.pytest)):
        print("+", *check, file=sys.stderr, flush=True)
        program = Path(sys.executable).with_name(check[0])
        status = subprocess.run([program, *check[1:]], cwd=ROOT, check=False).returncode
        if status:
            return 1
    return 0
