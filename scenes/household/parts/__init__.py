"""Parts: outlines, solids, legs, and the family of objects that is made from numbers drawn at random.

May import nothing beside itself; furniture and wares build on it.
"""
