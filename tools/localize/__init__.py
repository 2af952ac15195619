"""Localization alone on logs and recordings, judged against their reference poses."""
