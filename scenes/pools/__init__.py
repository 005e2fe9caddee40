"""Pools: spheres dropped on a whole scene, and the surfaces that carry those that come to rest together.

May import `segmentation`, `scans` and the shared stack; knows nothing of functions.
"""
