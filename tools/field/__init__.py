"""The field trial: the bundle on a virtual robot's computer, started at boot, with faults."""
