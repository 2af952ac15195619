"""filterpy's Kalman filter, imported without SciPy."""

from __future__ import annotations

from robot_agent.light_import import import_lightly

KalmanFilter = import_lightly("filterpy.kalman").KalmanFilter
