"""Segmentation: a level scan falls into floor, walls and objects (paper, §IV-C).

May import `scans`; knows nothing of what objects are for.
"""
