"""Shipped truths of robots that are of another model."""
