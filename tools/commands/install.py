"""``patrol install``: the agent as a service that starts at boot."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from tools.deploy.service import activate, deploy, next_steps, this_program


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = (
        "example: sudo patrol install robot1.toml\n"
        "         patrol install robot1.toml --root look    # write below look/ only\n\n"
        "Writes etc/systemd/system/patrol@.service, etc/udev/rules.d/60-patrol.rules,\n"
        "etc/modules-load.d/patrol.conf, etc/sysusers.d/patrol.conf and etc/patrol/ROBOT.toml,\n"
        "and checks them. As root on a running system it also makes the user, loads the drivers\n"
        "and has systemd and udev read the files. Starts nothing."
    )
    parser.add_argument("configs", nargs="*", type=Path, metavar="ROBOT.toml")
    parser.add_argument("--root", type=Path, default=Path("/"), metavar="DIR", help="default: /")
    parser.add_argument("--user", default="patrol", help="user the service runs as")
    parser.add_argument(
        "--program", type=Path, default=this_program(), help="the patrol to start; default: this"
    )


def run(options: argparse.Namespace) -> int:
    """Write the files, check them, print the next steps; return 1 when a check fails, else 0."""
    done = deploy(options.root, options.configs, options.user, options.program)
    activation = activate(options.root) if done.fit else []
    done.findings += activation
    for path in done.written:
        print(f"written  {path}")
    for path in done.kept:
        print(f"kept     {path}")
    for finding in done.findings:
        print(f"{finding.verdict:<8} {finding.subject}: {finding.text}")
        if finding.remedy:
            print(f"         {finding.remedy}")
    print("\nnext:", file=sys.stderr)
    names = [config.stem for config in options.configs]
    for step in next_steps(names, activated=bool(activation)):
        print(f"  {step}", file=sys.stderr)
    return 0 if done.fit else 1
