"""The operator's monitor: receives the team's telemetry, derives alarms, shows both."""
