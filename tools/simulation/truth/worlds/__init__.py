"""The shipped truths, one file each."""
