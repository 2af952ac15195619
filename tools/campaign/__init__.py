"""The fault campaign: every fault injected into a patrolling robot, its reaction measured."""
