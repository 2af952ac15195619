"""P2OS: the Pioneer base controller's serial protocol, its client session and its emulator.

Not supported: a laser wired to one of the base's auxiliary ports. The controller would pass its
bytes on in SERAUX packets of at most 200 bytes, each asked for by GETAUX, beside the SIPs at the
host's rate: less than one scan a second. A laser needs a serial port of its own. SERAUX packets
are decoded for slow devices.
"""
