"""Impairment: copies of labelled objects that look right and do not work, and copies with harmless changes.

May import the shared stack and `household`. `impairments.py` lists every kind.
"""
