"""From a velocity in the map to wheel commands: heading loop, and the safety gate after it."""
