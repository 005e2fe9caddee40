"""Collision: from a cloud's points to the surface that spheres meet in Bullet, as triangles or convex pieces.

May import `clouds` and the words of the package's root, and nothing of the engine but how it loads shapes.
"""
