"""The onboard agent: bytes in, one patrol decision per base report, bytes out."""
