"""Recordings and CARMEN logs: reading, upgrading, converting."""
