"""Shapes: what a collision shape keeps of what an object is for, and at what price.

An object's visual mesh is the truth; every candidate is measured as the engine holds it, not as a mesh reader shows it.
"""
