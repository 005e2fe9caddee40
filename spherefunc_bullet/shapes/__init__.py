"""Shapes: how well a collision shape preserves the function of an object, and at which cost.

The visual mesh of an object is the reference; every candidate is measured as the engine loads it.
"""
