"""The emulated LMS 1xx: the scanner's side of the connection, paced like one."""
