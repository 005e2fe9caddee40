"""Household: the built-in catalogue of made-up objects, in the paper's proportions (§IV-A).

May import nothing beside itself: furniture and wares are put together from parts.
"""
