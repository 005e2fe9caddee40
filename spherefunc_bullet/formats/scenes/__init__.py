"""Formats with several parts, each in its own frame, which are joined to one object."""
