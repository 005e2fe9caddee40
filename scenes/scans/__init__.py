"""Scans: what depth sensors saw, from files and depth images, turned level by floor and walls (paper, §IV-C).

May import the shared stack up to `formats` and `clouds`; knows nothing of objects.
"""
