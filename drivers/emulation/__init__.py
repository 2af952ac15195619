"""Shared by all emulated devices: ports, line faults, timed bytes."""
