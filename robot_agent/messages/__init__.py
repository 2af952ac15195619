"""What goes in and out of the agent: events, effects, telemetry payloads and their schemas."""
