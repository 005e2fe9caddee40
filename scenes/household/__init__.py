"""Household: the built-in catalogue of made-up objects, in the paper's proportions (§IV-A).

May import only the shared stack: furniture and wares are put together from parts.
"""
