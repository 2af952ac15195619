"""The live process of an agent: threads, real time, network and service manager."""
