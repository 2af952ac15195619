"""Device drivers of the Pioneer 2-DX: sans-I/O sessions, emulated devices, serial links, camera.

Everywhere in this package ``t`` is monotonic agent time in seconds.
"""
