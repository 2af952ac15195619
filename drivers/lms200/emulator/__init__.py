"""The emulated LMS 200: the laser's side of the line, paced like one."""
