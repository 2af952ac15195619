"""SICK LMS 200 laser scanner: telegrams, the host's session, and an emulated laser."""
