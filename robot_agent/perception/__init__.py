"""Perception: tracks of objects that are not in the map, by laser, sonar and camera."""
