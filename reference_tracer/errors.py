"""The one error users see: what is wrong, where, and what would be right."""


class InputError(ValueError):
    """Input a user can correct. Its text is one complete line; the command line prints it and exits with 2."""


class UnsupportedError(InputError):
    """A scene asks for something that this part of raytruth cannot express; the text gives the reason."""


class MissingError(InputError):
    """A program or package that is not installed on this machine; the text says which, and how to install it."""
