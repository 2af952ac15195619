"""Recordings fed to an agent again, or to a driver as devices; logs made into recordings."""
