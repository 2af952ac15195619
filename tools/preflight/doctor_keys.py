"""Checks the connection to the operator: certificates with their dates, and the endpoint."""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from urllib.parse import urlsplit

from robot_agent.config import TelemetrySettings
from robot_agent.process.certificate_dates import CertificateError, first_trouble, read_dates
from robot_agent.process.key_rights import KEY, rights_trouble
from tools.preflight.finding import Finding, ok, skipped, warning

OPERATOR_LIMIT_S = 1.0


class RefusedError(Exception):
    """One end refuses the other's certificate, with the reason."""


def examine_keys(keys: str, wall: Callable[[], float] = time.time) -> Finding:
    """Check the robot's certificates by its clock, and who may read its key.

    A warning at most, as it patrols without.
    """
    if not keys:
        return skipped("keys", "telemetry.keys is not set: telemetry is not encrypted")
    try:
        certificates = read_dates(Path(keys))
    except CertificateError as error:
        return warning("keys", str(error), "copy this robot's folder of `patrol keys` there")
    if not os.access(Path(keys) / KEY, os.R_OK):
        text = f"{keys}/{KEY}: this user cannot read the private key"
        return warning(
            "keys", text, f"copy it there, owned by the service's user: `chown patrol {keys}/*`"
        )
    text, _, remedy = first_trouble(certificates, wall()).partition(": ")
    if text:
        return warning("keys", text, remedy)
    if trouble := rights_trouble(Path(keys)):
        text, _, remedy = trouble.rpartition(": ")
        return warning("keys", text, remedy)
    text, _, remedy = next(
        filter(None, (each.ends_soon(wall()) for each in certificates)), ""
    ).partition(": ")
    if text:
        return warning("keys", text, remedy)
    return ok("keys", f"{keys}: valid until {min(each.ends for each in certificates):%Y-%m-%d}")


def examine_operator(settings: TelemetrySettings) -> Finding:
    """Check whether the operator's endpoint accepts a connection; a warning at most if not.

    With certificates, both ends must accept each other's.
    """
    endpoint = settings.operator
    if not endpoint:
        return skipped("operator", "telemetry.operator is not set: no telemetry is sent")
    address = urlsplit(endpoint.replace("/", "://", 1))
    try:
        with socket.create_connection((address.hostname, address.port), OPERATOR_LIMIT_S) as line:
            if settings.keys:
                _shake_hands(line, str(address.hostname), Path(settings.keys))
    except RefusedError as error:
        remedy = "set both clocks; else copy certificates of the same `patrol keys` to both ends"
        return warning("operator", f"{endpoint}: certificates do not fit ({error})", remedy)
    except (OSError, ValueError) as error:
        remedy = "start `patrol monitor` there, or check the Wi-Fi; the robot patrols without"
        return warning("operator", f"{endpoint}: {error}", remedy)
    return ok("operator", f"{endpoint} answers")


def _shake_hands(line: socket.socket, host: str, keys: Path) -> None:
    """Agree on TLS with certificates of both ends; raises RefusedError or OSError."""
    import ssl  # 5 MB, which the agent, whose checks are the doctor's, does without

    try:
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        context.load_verify_locations(keys / "ca.pem")
        context.load_cert_chain(keys / "certificate.pem", keys / "key.pem")
        with context.wrap_socket(line, server_hostname=host) as secured:
            secured.settimeout(OPERATOR_LIMIT_S / 2)
            with suppress(TimeoutError):
                secured.recv(1)  # a refusal of this end's certificate comes after the agreement
    except ssl.SSLError as error:
        reason = getattr(error, "verify_message", "") or error.reason or str(error)
        raise RefusedError(reason) from error
