"""Inputs and outputs of the agent: events, effects, telemetry payloads and their schemas."""
