"""Household: the built-in catalogue of made-up objects, in the paper's proportions (§IV-A).

May import nothing else of the scenes: furniture and wares are built from parts.
"""
