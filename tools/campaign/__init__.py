"""The fault campaign: one patrolling robot, every fault, and how it reacts."""
