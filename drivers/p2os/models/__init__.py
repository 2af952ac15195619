"""Robot models as data, one TOML file for each subclass that a controller may report."""
