"""Formats of points without faces."""
