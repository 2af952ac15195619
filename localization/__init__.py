"""Monte Carlo localization (particle filter) against a pre-built occupancy map.

Everywhere in this package ``t`` is monotonic agent time in seconds.
"""
