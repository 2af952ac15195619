"""SICK LMS 1xx: SOPAS over TCP, in both dialects. TiM5xx and LMS 5xx where the telegrams agree."""
