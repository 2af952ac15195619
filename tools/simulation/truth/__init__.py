"""What the simulated robots and their world really are; no program under test reads it."""
