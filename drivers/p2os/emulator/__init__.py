"""The emulated P2OS controller: what a real one answers, does and reports."""
