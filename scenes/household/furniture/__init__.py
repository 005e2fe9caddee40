"""Furniture: chairs, stools, sofas, tables, desks and cabinets, one file a family.

May import `parts`, and one family another's; never wares.
"""
