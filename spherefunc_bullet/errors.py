"""The one exception that means "the user can mend this"."""


class InputError(ValueError):
    """A file, value or option that cannot be used.

    The message is one line: what it is about, what was expected, what came, and the fix.
    The command line prints it and exits with code 2; library code lets it pass.
    """
