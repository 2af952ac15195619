"""Drawing of a border on its map, in a browser."""
