"""Preflight of one robot: devices, ports, power and map, each finding with its remedy."""
