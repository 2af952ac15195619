"""The disk of the virtual robot's computer: Debian 12 from its packages, made once and kept.

The packages come from the Debian sources that this machine's apt is set up with.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from tools.field.needed_programs import with_sbin
from tools.field.trial_error import TrialError

RELEASE = "bookworm"
PACKAGES = (
    *("linux-image-amd64", "systemd", "systemd-sysv", "udev", "dbus", "kmod", "e2fsprogs"),
    *("python3", "python3-venv", "sudo", "procps", "util-linux", "qemu-guest-agent"),
)
"""linux-image-cloud-amd64 would be smaller, but has no drivers of USB adapters."""
SIZE = "4G"
_BUILD_LIMIT_S = 1800.0
_TARGETS = "$(REPO_URI)|$(CODENAME)|$(COMPONENT)|$(ORIGIN)"
_PACKAGE_LISTS = "Created-By: Packages"
_LAYOUT = 1
"""Of what is made from the packages; increase it with every change of the steps below."""
_STEPS = (
    'echo robot > "$1/etc/hostname" && echo \'127.0.0.1 localhost robot\' > "$1/etc/hosts"',
    "echo '/dev/vda / ext4 errors=remount-ro 0 1' > \"$1/etc/fstab\"",
)
"""Shell lines run on the finished root, which is $1."""


@dataclass(frozen=True, slots=True)
class MachineImage:
    """A bootable Debian: disk (ext4, raw), kernel and first file system."""

    disk: Path
    kernel: Path
    initrd: Path


def cache_folder() -> Path:
    """Return the user's folder for images of machines."""
    base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "border-patrol" / "field"


def machine_image(cache: Path, report: Callable[[str], None]) -> MachineImage:
    """Return the image of today's versions, made now if there is none; others are deleted.

    Raises TrialError when it cannot be made.
    """
    sources = debian_sources(_run("apt-get", "indextargets", "--format", _TARGETS, _PACKAGE_LISTS))
    folder = cache / f"debian-{_key()}"
    image = MachineImage(folder / "disk.raw", folder / "vmlinuz", folder / "initrd.img")
    if all(path.exists() for path in (image.disk, image.kernel, image.initrd)):
        return image
    report("building Debian 12, once (some minutes)")
    shutil.rmtree(cache, ignore_errors=True)
    folder.mkdir(parents=True)
    try:
        _build(image, sources)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)  # half an image must not be taken for one
        raise
    return image


def debian_sources(listed: str) -> list[str]:
    """Return Debian 12's sources among apt's, as lines of sources.list; raises TrialError if none.

    listed: URI, code name, component and origin of each, joined by |.
    """
    found = []
    for line in listed.splitlines():
        uri, codename, component, origin = line.split("|")
        if origin == "Debian" and codename.startswith(RELEASE) and component == "main":
            found.append(f"deb {uri} {codename} {component}")
    if not found:
        raise TrialError(
            "this machine's apt knows no packages of Debian 12: add its sources, then run "
            "`apt-get update`"
        )
    return list(dict.fromkeys(found))


def _key() -> str:
    """Return what changes with the versions of the packages."""
    shown = _run("apt-cache", "show", "--no-all-versions", *PACKAGES)
    wanted = ("Package:", "Version:", "SHA256:")
    versions = [line for line in shown.splitlines() if line.startswith(wanted)]
    return hashlib.sha256("\n".join((*versions, *_STEPS, SIZE, str(_LAYOUT))).encode()).hexdigest()[
        :12
    ]


def _build(image: MachineImage, sources: Sequence[str]) -> None:
    # The disk is made inside mmdebstrap's name space, where owners are right without root; the bind
    # leaves out what is mounted below the root, such as /proc.
    steps = (
        *_STEPS,
        f'cp "$1/vmlinuz" {image.kernel} && cp "$1/initrd.img" {image.initrd}',
        'chroot "$1" apt-get clean && mkdir "$1.bare" && mount --bind "$1" "$1.bare"',
        f'mke2fs -q -t ext4 -d "$1.bare" {image.disk} {SIZE}',
        'umount "$1.bare" && rmdir "$1.bare"',
    )
    _run(
        *("mmdebstrap", "--quiet", "--variant=minbase", f"--include={','.join(PACKAGES)}"),
        *(f"--customize-hook={step}" for step in steps),
        *(RELEASE, "/dev/null", *sources),
    )


def _run(*command: str) -> str:
    try:
        done = subprocess.run(
            command,
            capture_output=True,
            text=True,
            check=False,
            timeout=_BUILD_LIMIT_S,
            env=with_sbin(),
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise TrialError(f"{command[0]}: {error}") from error
    if done.returncode:
        raise TrialError(f"{command[0]}: {done.stderr.strip()[-400:]}")
    return done.stdout
