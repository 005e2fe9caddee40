"""Scans of depth sensors, from files and depth images, levelled by floor and walls (paper, §IV-C).

May import the shared stack up to `formats` and `clouds`; knows nothing about objects.
"""
