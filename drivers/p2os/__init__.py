"""P2OS: the Pioneer base controller's serial protocol, its client session and its emulated twin."""
