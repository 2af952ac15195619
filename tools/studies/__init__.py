"""Studies over many runs: seeds and settings compared, the paper's experiment, the soak."""
