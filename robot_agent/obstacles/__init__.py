"""What stands about the robot, for the safety gate."""
