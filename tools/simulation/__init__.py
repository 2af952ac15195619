"""The simulated world: bodies, sensors, cameras, strangers, and emulated robots."""
