"""Commands around the agent: benches, maps, replay, the operator side.

Everywhere in this package ``t`` is monotonic agent time in seconds.
"""
