"""Robot models as data, one TOML file for each subclass a controller may report."""
