"""Maps and borders: what is known of the world before the patrol starts."""
