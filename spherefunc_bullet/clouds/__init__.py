"""Clouds: an object as points in metres, z up, on the ground, sampled from meshes (paper, §III-A and §IV-A).

May import `formats` and the words of the package's root; knows nothing of simulators or learning.
"""
