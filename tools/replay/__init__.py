"""Replay of recordings through an agent or as devices; conversion of logs to recordings."""
