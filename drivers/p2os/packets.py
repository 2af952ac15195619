"""The packets a robot sends, by their first data byte."""

from __future__ import annotations

from drivers.p2os.config_packet import CONFIG_TYPE, ConfigPacket, decode_config
from drivers.p2os.robot_identity import RobotIdentity, decode_sync_reply
from drivers.p2os.sip import Sip, SipTail, decode_sip, is_sip

__all__ = [
    "CONFIG_TYPE",
    "ConfigPacket",
    "RobotIdentity",
    "Sip",
    "SipTail",
    "decode_config",
    "decode_sip",
    "decode_sync_reply",
    "is_sip",
]
