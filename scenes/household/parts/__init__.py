"""Parts: outlines, solids, legs, and families of objects drawn from one builder with random dimensions.

May import nothing else of the catalogue; furniture and wares build on it.
"""
