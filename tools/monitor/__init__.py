"""The operator's side: hears the team's telemetry and shows it."""
