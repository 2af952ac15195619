"""Commands around the agent: benches, maps, replay, the operator's monitor.

Everywhere below ``t`` is monotonic agent time in seconds.
"""
