"""Settling: where spheres come to rest on clouds; runs are cached by the content of files (paper, §III-A).

May import `clouds`, `formats`, `processes` and the `simulator` interface, but not learning, which uses the drops.
"""
