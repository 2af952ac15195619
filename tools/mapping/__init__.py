"""Pre-built maps: built from logs or floor plans, checked, drawn."""
