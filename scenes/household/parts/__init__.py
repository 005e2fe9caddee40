"""Parts: solids, legs, and the family of objects that is made from numbers drawn at random.

May import only the words of the shared stack; furniture and wares build on it.
"""
