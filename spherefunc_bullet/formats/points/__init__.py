"""Formats for point clouds, which have no faces."""
