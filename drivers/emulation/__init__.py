"""What all emulated devices share: their ports, faults of their lines, timed bytes."""
