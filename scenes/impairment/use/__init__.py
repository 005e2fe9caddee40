"""Objects in use (laid tables, seats with something on them, cups that hold something), and as a sensor sees them.

Copies as in the folder above, most of which work as their originals do.
"""
