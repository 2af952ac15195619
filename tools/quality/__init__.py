"""Checks of the code itself: mutants of the safety gate, decisions kept as regression."""
