"""``patrol doctor ROBOT.toml``: preflight with remedies."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from robot_agent.config import load_config
from tools.deploy.service_sandbox import run_in_sandbox
from tools.number_range import positive
from tools.preflight.doctor import TRIAL_LIMIT_S, examine, is_fit
from tools.preflight.finding import Finding, Verdict
from tools.preflight.watchdog_trial import LIMIT_S, WARNING, try_watchdog
from tools.progress import progress_line

COLOURS = {
    Verdict.OK: "green",
    Verdict.WARNING: "yellow",
    Verdict.FAILED: "red",
    Verdict.NOT_YET: "cyan",
    Verdict.SKIPPED: "dim",
}


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = (
        "example: patrol doctor robot1.toml\n\n"
        "Nothing moves, but for --watchdog-test. Ends with status 0 when the robot may patrol,\n"
        "1 when something failed; warnings do not count. In a unit:\n"
        "ExecStartPre=patrol doctor /etc/patrol/robot1.toml"
        "\n\nWhat the service itself may open and read: "
        "sudo patrol doctor --as-service /etc/patrol/robot1.toml"
    )
    parser.add_argument("config", type=Path, metavar="ROBOT.toml", help="the robot's configuration")
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")
    parser.add_argument(
        "--watchdog-test",
        action="store_true",
        help="only see whether the base stops by itself: turns the wheels, off the ground",
    )
    parser.add_argument(
        "--wheels-off-ground", action="store_true", help="answers the question of --watchdog-test"
    )
    parser.add_argument(
        "--limit", type=positive, default=TRIAL_LIMIT_S, metavar="S", help="wait for silent devices"
    )
    parser.add_argument(
        "--as-service",
        action="store_true",
        help="in the sandbox of the service, as its user; with sudo, where systemd runs",
    )


def run(options: argparse.Namespace) -> int:
    """Check one robot and print the findings; return 0 if it may patrol, else 1."""
    if options.as_service:
        return run_in_sandbox(words_of(options))
    if options.watchdog_test:
        if not (options.wheels_off_ground or wheels_are_off_ground()):
            print("patrol doctor: nothing was moved", file=sys.stderr)
            return 2
        with progress_line("watchdog", LIMIT_S, "s") as progress:
            findings = [try_watchdog(load_config(options.config).base, progress)]
    else:
        with progress_line("doctor", options.limit, "s") as progress:
            findings = examine(options.config, options.limit, progress)
    if options.json:
        rows = [
            {
                "check": finding.subject,
                "verdict": finding.verdict,
                "found": finding.text,
                "remedy": finding.remedy,
            }
            for finding in findings
        ]
        print(json.dumps({"fit": is_fit(findings), "checks": rows}, indent=2))
    elif not (sys.stdout.isatty() and print_table(findings)):
        print("\n".join(plain_lines(findings)))
    return 0 if is_fit(findings) else 1


def words_of(options: argparse.Namespace) -> list[str]:
    """Return the command line of these options without ``--as-service``."""
    flags = {
        "--json": options.json,
        "--watchdog-test": options.watchdog_test,
        "--wheels-off-ground": options.wheels_off_ground,
    }
    given = [flag for flag, is_given in flags.items() if is_given]
    return ["doctor", str(options.config.absolute()), *given, "--limit", f"{options.limit:g}"]


def wheels_are_off_ground() -> bool:
    """Ask on the terminal; return whether the answer is yes, False where there is no terminal."""
    print(f"{WARNING}.", file=sys.stderr)
    if not sys.stdin.isatty():
        print("patrol doctor: say so with --wheels-off-ground", file=sys.stderr)
        return False
    return input("Are they? Type yes: ").strip().lower() == "yes"


def plain_lines(findings: list[Finding]) -> list[str]:
    """Return the findings as lines: verdict, check, text; remedies indented below."""
    lines = []
    for finding in findings:
        lines.append(f"{finding.verdict:<8} {finding.subject:<14} {finding.text}")
        if finding.remedy:
            lines.append(f"{'':<23} -> {finding.remedy}")
    return lines


def print_table(findings: list[Finding]) -> bool:
    """Print a coloured table; return False, printing nothing, where ``rich`` is not installed."""
    try:
        from rich.console import Console
        from rich.table import Table
        from rich.text import Text
    except ImportError:
        return False
    table = Table("check", "verdict", "found", "remedy")
    for finding in findings:
        colour = COLOURS[finding.verdict]
        table.add_row(
            Text(finding.subject),
            Text(finding.verdict, style=colour),
            Text(finding.text),
            Text(finding.remedy),
        )
    Console().print(table)
    return True
