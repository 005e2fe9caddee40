"""Statics: stable poses and standing of an object, from its weight and supports, without simulating motion.

May import `mechanics` and `clouds`; every backend may use it.
"""
