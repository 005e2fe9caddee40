"""Settling: where spheres come to rest on clouds, each object simulated once and kept by content (paper, §III-A).

May import `clouds`, `formats`, `processes` and the `simulator` interface;
never learning, which reads what is kept here.
"""
