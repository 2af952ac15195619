"""Studies over many simulated runs: seeds and settings, the paper's experiment, the soak test."""
