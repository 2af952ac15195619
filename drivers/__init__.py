"""Device drivers of the Pioneer 2-DX: sans-I/O sessions, their emulated twins, serial links."""
