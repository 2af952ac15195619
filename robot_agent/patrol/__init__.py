"""The paper's method: elementary behaviors, actions composed of them, and the fuzzy supervisor."""
