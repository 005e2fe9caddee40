"""Data sets: which files there are, what each object is for, made-up catalogues, and shards of a job array.

May import `formats`, for reading and writing, and the words of the package's root.
"""
