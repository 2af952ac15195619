"""Localization alone on logs and recordings, evaluated by their reference poses."""
