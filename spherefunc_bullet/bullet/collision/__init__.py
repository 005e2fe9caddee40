"""Collision shapes for Bullet, made from the points of a cloud: triangles or convex pieces.

May import `clouds` and the modules of the package's root, but not the engine.
"""
