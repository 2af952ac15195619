"""Deployment of the agent: systemd service, offline bundle, certificates, udev rules."""
