"""The flight recorder and the header of its files."""
