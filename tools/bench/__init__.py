"""The bench: emulated robots in a simulated world, in lockstep or in real time."""
