"""Obstacle points around the robot, for the safety gate."""
