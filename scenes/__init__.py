"""Scenes: where objects come from: catalogues, furniture libraries, scanned rooms and virtual ones.

May import the shared stack, `spherefunc_bullet`; neither simulator nor experiments.
"""
