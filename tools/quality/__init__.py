"""Checks of the code itself: mutation test of the safety gate, regression test of decisions."""
