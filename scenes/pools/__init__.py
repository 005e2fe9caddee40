"""Pools: spheres dropped on a whole scene, and what carries those that come to rest together.

May import `segmentation`, `scans` and the shared stack; knows nothing of functions.
"""
