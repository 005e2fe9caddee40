"""Segmentation of a level scan into floor, walls and objects (paper, §IV-C).

May import `scans` and the shared stack's `errors`; knows nothing about functions of objects.
"""
