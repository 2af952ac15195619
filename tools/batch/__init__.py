"""Many ideal benches at once: the decision layer of all robots of all runs in arrays."""
