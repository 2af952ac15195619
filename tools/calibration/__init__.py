"""What is fitted to a robot: camera, team colour, and what perception makes of a log."""
