"""Pose of the robot: odometry, localization, and the pose kept over restarts."""
