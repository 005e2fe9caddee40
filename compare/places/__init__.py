"""Benchmarks of places: by a separate simulation, by water, by catalogues and by hand labels."""
