"""A small certificate authority: one certificate for the operator, one for each robot.

The folder holds ``authority/`` (keep it off the network), ``operator/`` (for the laptop), one
folder per robot, and ``TEAM.site/`` for the monitor of a site that forwards a whole team to a head
office. Each of these has ``ca.pem``, ``certificate.pem`` and ``key.pem``; the operator's also has
``robots.json`` and ``sites.json``, the names its access control admits.
"""

from __future__ import annotations

import datetime
import errno
import ipaddress
import os
from collections.abc import Sequence
from pathlib import Path

import msgspec
from cryptography import x509
from cryptography.exceptions import InvalidSignature, UnsupportedAlgorithm
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from maps.whole_file import whole_file, write_whole
from robot_agent.config import KeyPart

CA, CERTIFICATE, KEY = "ca.pem", "certificate.pem", "key.pem"
ROBOTS, SITES = "robots.json", "sites.json"
SITE_SUFFIX = ".site"
"""Of a site's folder: no robot can have a name with a dot."""
AUTHORITY, OPERATOR = "authority", "operator"
_BEGIN = datetime.datetime(1970, 1, 1, tzinfo=datetime.UTC)
"""Certificates are valid from here on: a computer without a clock battery starts with it."""


class KeysError(ValueError):
    """Keys cannot be made or used; the message names file, reason and remedy."""


class RobotName(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Team and name of a robot that has a certificate."""

    team: KeyPart
    robot: KeyPart

    @property
    def common_name(self) -> str:
        """Common name in its certificate, ``team/robot``."""
        return f"{self.team}/{self.robot}"


def make_keys(
    folder: Path,
    team: str,
    robots: Sequence[str],
    hosts: Sequence[str],
    days: int = 3650,
    *,
    site: bool = False,
) -> list[str]:
    """Make the missing certificates in a folder; return the names of those made.

    hosts: names and addresses at which robots reach the operator. days: validity from
    now on; they are valid before, for robots whose clocks are not set. site: also for the monitor
    of a site that forwards the team. Existing keys are kept, so that robots can be added later.

    Raises:
        KeysError: a name is invalid, ``hosts`` is empty without an operator's certificate, or
            existing files cannot be read.
    """
    names = [_checked(team, robot) for robot in robots]
    if site:
        _checked(team, "any")
    made = []
    authority = folder / AUTHORITY
    if not (authority / KEY).exists():
        _make_authority(authority, days)
        made.append(AUTHORITY)
    issuer = _Issuer(authority, days)
    if not (folder / OPERATOR / KEY).exists():
        if not hosts:
            raise KeysError(
                f"{folder / OPERATOR}: its certificate needs the address robots connect to; "
                "give --host with the operator's address, e.g. --host 192.168.1.10"
            )
        issuer.issue(folder / OPERATOR, "operator", hosts)
        made.append(OPERATOR)
    for name in names:
        if not (folder / name.robot / KEY).exists():
            issuer.issue(folder / name.robot, name.common_name, ())
            made.append(name.robot)
    _add_robots(folder / OPERATOR / ROBOTS, names)
    if site:
        own = team + SITE_SUFFIX
        if not (folder / own / KEY).exists():
            # A robot's common name has a slash, a site's has none.
            issuer.issue(folder / own, team, ())
            made.append(own)
        sites = sorted({*known_sites(folder / OPERATOR), team})
        write_whole(folder / OPERATOR / SITES, msgspec.json.encode(sites) + b"\n")
    return made


def known_robots(folder: Path) -> list[RobotName]:
    """Return the robots that an operator's folder of keys admits.

    Raises:
        KeysError: the list is missing or damaged.
    """
    path = folder / ROBOTS
    try:
        return msgspec.json.decode(path.read_bytes(), type=list[RobotName])
    except OSError as error:
        raise KeysError(
            f"{path}: cannot be read ({error.strerror}); "
            "give the operator's folder of `patrol keys`"
        ) from error
    except msgspec.DecodeError as error:
        raise KeysError(f"{path}: {error}; run `patrol keys` again") from error


def known_sites(folder: Path) -> list[str]:
    """Return the teams whose sites an operator's folder of keys admits.

    Raises:
        KeysError: the list is damaged.
    """
    path = folder / SITES
    try:
        return msgspec.json.decode(path.read_bytes(), type=list[KeyPart])
    except FileNotFoundError:
        return []
    except (OSError, msgspec.DecodeError) as error:
        raise KeysError(f"{path}: {error}; run `patrol keys` again") from error


def _checked(team: str, robot: str) -> RobotName:
    if robot in (AUTHORITY, OPERATOR):
        raise KeysError(f"robot {robot!r}: the name is taken; give another one")
    try:
        return msgspec.convert({"team": team, "robot": robot}, RobotName)
    except msgspec.ValidationError as error:
        raise KeysError(
            f"team {team!r}, robot {robot!r}: {error}; use letters, digits, _ and -"
        ) from error


def _add_robots(path: Path, names: Sequence[RobotName]) -> None:
    known = known_robots(path.parent) if path.exists() else []
    wanted = sorted({*known, *names}, key=lambda name: name.common_name)
    write_whole(path, msgspec.json.format(msgspec.json.encode(wanted)) + b"\n")


def _make_authority(folder: Path, days: int) -> None:
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "border patrol")])
    certificate = (
        _builder(name, name, key.public_key(), days)
        .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        .sign(key, hashes.SHA256())
    )
    write_whole(folder / CA, certificate.public_bytes(serialization.Encoding.PEM))
    _write_key(folder, key)


class _Issuer:
    """Signs certificates with the authority's key."""

    def __init__(self, folder: Path, days: int) -> None:
        self._days = days
        try:
            self._ca = (folder / CA).read_bytes()
            self._certificate = x509.load_pem_x509_certificate(self._ca)
            key = serialization.load_pem_private_key((folder / KEY).read_bytes(), None)
        except OSError as error:
            raise KeysError(
                f"{error.filename}: cannot be read ({error.strerror}); check path and rights"
            ) from error
        except (ValueError, TypeError, UnsupportedAlgorithm, InvalidSignature) as error:
            raise KeysError(
                f"{folder}: holds no authority of `patrol keys` ({error}); use an empty folder"
            ) from error
        if not isinstance(key, ec.EllipticCurvePrivateKey):
            raise KeysError(f"{folder / KEY}: is no key of `patrol keys`; use an empty folder")
        self._key = key

    def issue(self, folder: Path, common_name: str, hosts: Sequence[str]) -> None:
        """Write key and certificate of one party.

        hosts: names and addresses of a server certificate; empty: a client certificate.
        """
        key = ec.generate_private_key(ec.SECP256R1())
        name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, common_name)])
        usage = ExtendedKeyUsageOID.SERVER_AUTH if hosts else ExtendedKeyUsageOID.CLIENT_AUTH
        builder = (
            _builder(name, self._certificate.subject, key.public_key(), self._days)
            .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
            .add_extension(x509.ExtendedKeyUsage([usage]), critical=False)
        )
        if hosts:
            alternatives = x509.SubjectAlternativeName([_host_name(host) for host in hosts])
            builder = builder.add_extension(alternatives, critical=False)
        certificate = builder.sign(self._key, hashes.SHA256())
        write_whole(folder / CERTIFICATE, certificate.public_bytes(serialization.Encoding.PEM))
        write_whole(folder / CA, self._ca)
        _write_key(folder, key)


def _builder(
    subject: x509.Name, issuer: x509.Name, key: ec.EllipticCurvePublicKey, days: int
) -> x509.CertificateBuilder:
    end = datetime.datetime.now(datetime.UTC) + datetime.timedelta(days=days)
    return (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(issuer)
        .public_key(key)
        .serial_number(x509.random_serial_number())
        .not_valid_before(_BEGIN)
        .not_valid_after(end)
    )


def _host_name(host: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(host))
    except ValueError:
        return x509.DNSName(host)


def _write_key(folder: Path, key: ec.EllipticCurvePrivateKey) -> None:
    """Write a private key readable by its owner only; raises FileExistsError if there is one.

    The last of a party's files: with it the party is complete.
    """
    if (folder / KEY).exists():
        raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(folder / KEY))
    pem = key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    )
    with whole_file(folder / KEY) as part:
        descriptor = os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(descriptor, "wb") as file:
            file.write(pem)
