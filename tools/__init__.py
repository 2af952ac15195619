"""Commands around the agent: benches, maps, replay, the operator side."""
