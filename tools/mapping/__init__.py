"""Building of maps from logs or floor plans; checks and pictures of maps."""
