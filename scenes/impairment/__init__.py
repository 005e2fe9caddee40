"""Impairment: copies of labelled objects that look right and do not work, and as many changes that must not matter.

May import the shared stack alone. `impairments.py` lists every kind.
"""
