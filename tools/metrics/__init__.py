"""Figures of a run from true positions: distance, contacts, meetings, idleness, wrecks."""
