"""Formats of several parts, each in a frame of its own, which become one object."""
