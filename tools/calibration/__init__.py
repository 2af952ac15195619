"""Calibration of camera and team colour, and evaluation of perception on logs and recordings."""
