"""Variety: a second catalogue, of furniture and vessels that differ from those of ``household`` in kind and make.

Builds on the parts of `household`, never on its families.
"""
