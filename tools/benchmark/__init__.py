"""Measures the performance figures that every change must keep, each with its unit and limit."""
