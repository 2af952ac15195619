"""Telemetry payloads and health texts from the agent's state."""
