"""Perception: tracks of what the map does not explain, by laser, sonar and camera."""
