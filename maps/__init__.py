"""Maps and borders: the environment as known before the patrol starts."""
