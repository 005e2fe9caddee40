"""File readers, one module per format: each takes a `sources.Source` and returns vertices and triangles.

A reader raises FormatError where it knows what is wrong. All other exceptions that damaged bytes cause in it, or in the
libraries that it uses, are caught in one place, ``files.refusing``.
"""


class FormatError(ValueError):
    """An unreadable file; the message says what is wrong with it, without its name."""
