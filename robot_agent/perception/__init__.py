"""Perception: where the teammates are, from laser points that the map does not explain."""
