"""Data sets: which files there are, what each object is for, generated catalogues, and shards of a job array.

May import `formats`, for reading and writing, and the modules of the package's root.
"""
