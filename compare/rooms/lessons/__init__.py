"""Lessons: what virtual rooms teach a model for scans, computed and kept.

May import `scenes` and the shared stack.
"""
