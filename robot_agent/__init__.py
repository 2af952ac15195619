"""The onboard agent: bytes in, one patrol decision per base report, bytes out.

Everywhere in this package ``t`` is monotonic agent time in seconds. Quantities are in SI units;
frames are those of REP-105: ``map``, ``odom``, ``base_link``. A pose named ``a_from_b`` transforms
points of frame b to frame a.
"""
