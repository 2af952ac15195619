"""The error of an emulated robot that cannot be made."""


class EmulateError(ValueError):
    """The robot cannot be emulated as asked; the message names the option and a remedy."""
