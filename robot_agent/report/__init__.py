"""What the operator and the recording are told."""
