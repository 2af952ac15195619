"""Where the robot is: odometry, localization, and the pose kept over restarts."""
