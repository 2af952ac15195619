"""From a velocity in the map to wheels: the heading loop, and the gate guarding every command."""
