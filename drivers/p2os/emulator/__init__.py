"""The emulated P2OS controller: its replies, motion and reports."""
