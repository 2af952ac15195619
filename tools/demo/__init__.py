"""The demo: emulated robots in real time, one unmodified agent process each, and an operator."""
