"""Particle-filter localization against a pre-built map."""
