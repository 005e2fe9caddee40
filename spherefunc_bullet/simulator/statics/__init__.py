"""Statics: what weight and support tell of an object that is free to move, without any motion.

May import `mechanics` and `clouds`; every backend may use it.
"""
