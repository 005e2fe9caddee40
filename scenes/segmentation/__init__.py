"""Segmentation: a level scan falls into floor, walls and objects (paper, §IV-C).

May import `scans` and the shared stack's `errors`; knows nothing of what objects are for.
"""
