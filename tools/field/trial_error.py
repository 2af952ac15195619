"""The error of a trial that could not be carried out."""


class TrialError(ValueError):
    """The trial cannot go on; the message holds the reason and a remedy."""
