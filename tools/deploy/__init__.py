"""Putting the agent on a robot's computer: service, offline bundle, certificates, port names."""
