"""The live side of an agent: threads, real time, network and the system's manager."""
