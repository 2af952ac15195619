"""Mapping from raw odometry and scans: scan matching, loop closing, a pose graph."""
