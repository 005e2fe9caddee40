"""Readers, one file a format: each takes a file's `sources.Source` and returns its vertices and triangles.

They raise FormatError where they know what is wrong; what else they or the libraries below them raise on
damaged bytes is caught in one place, ``files.refusing``.
"""


class FormatError(ValueError):
    """What is wrong with a file, in words for its owner, without its name."""
