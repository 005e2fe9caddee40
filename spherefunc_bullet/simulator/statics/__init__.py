"""Statics: stable poses and standing of an object, from its weight and supports, without simulation of motion.

May import `mechanics` and `clouds`; every backend may use it.
"""
