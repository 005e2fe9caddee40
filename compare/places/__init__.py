"""Exams of places: by a world of their own, by water, by catalogues and by hand."""
