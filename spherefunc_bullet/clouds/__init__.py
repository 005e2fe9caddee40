"""Clouds: objects as points in metres, z up, on the ground, sampled from meshes (paper, §III-A and §IV-A).

May import `formats` and the modules of the package's root, but not simulators or learning.
"""
