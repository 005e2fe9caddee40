"""Benchmarks of places: by another world, by water, by catalogues and by labels set by hand."""
